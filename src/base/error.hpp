// The one exception of Skein: a clear line for the user and an exit code.
#pragma once
#include <stdexcept>
#include <string>

namespace skein {

/// Exit codes of the command line (documented in docs/cli.md).
enum class ExitCode : int {
  kOk = 0,
  kInvalidMesh = 1,  ///< the mesh given is not valid (check, or input refused)
  kUsage = 2,        ///< bad command line
  kInput = 3,        ///< a file is missing, truncated, or does not fit the others
  kOutput = 4,       ///< an output cannot be written
  kInternal = 5,     ///< a bug of Skein
};

/// what() is one line: file, line or entity, what is wrong, what to do.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& line) : std::runtime_error(line), code_(code) {}
  [[nodiscard]] ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

}  // namespace skein
