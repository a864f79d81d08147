/// \file
/// The one exception of Skein.
#pragma once
#include <stdexcept>
#include <string>

#include "skein/export.h"

namespace skein {

/// What went wrong. The program `skein` ends with the same numbers (docs/cli.md).
enum class ErrorCode : int {
  kOk = 0,           ///< nothing; no Error has this code
  kInvalidMesh = 1,  ///< the mesh given is not valid: inverted, flat or duplicate tetrahedra, numbers out of range, ...
  kUsage = 2,        ///< an option or an argument makes no sense
  kInput = 3,        ///< a metric, a size or a field is not valid, or does not fit the mesh
  kOutput = 4,       ///< a file cannot be written (the program only)
  kInternal = 5,     ///< out of memory, or a bug of Skein
  kCancelled = 6,    ///< the progress function has asked to stop
  kAlone = 7,        ///< this rank alone failed, and the others may wait for it: end the run (MPI_Abort)
};

/// All functions of Skein fail with this exception, on all ranks of the communicator alike: same code, same text.
/// The exception to that is ErrorCode::kAlone; see docs/library.md, "Errors". what() is one line: the entity, what is
/// wrong with it, and what to do.
class SKEIN_EXPORT Error : public std::runtime_error {
 public:
  /// An error with its code and its line of text.
  Error(ErrorCode code, const std::string& line) : std::runtime_error(line), code_(code) {}
  /// What kind of error it is.
  [[nodiscard]] ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace skein
