// One rank's handle of a file that other ranks have open, too. Used by comm/file.cpp only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/error.hpp"

namespace skein::detail {

/// Nothing here is collective, so that an exception on one rank can always close its handle. Failures are Error(kInput)
/// for files opened for reading, Error(kOutput) for files opened for writing; their text begins with `name`.
class RawFile {
 public:
  enum class Mode { kRead, kWrite };
  RawFile(std::string name, Mode mode) : name_(std::move(name)), mode_(mode) {}
  virtual ~RawFile() = default;
  RawFile(const RawFile&) = delete;
  RawFile& operator=(const RawFile&) = delete;

  /// Reads from byte `at` into `out`. Returns the number of bytes read; fewer than wanted only at the end of the file.
  virtual std::size_t read(std::int64_t at, std::span<std::byte> out) = 0;
  virtual void write(std::int64_t at, std::span<const std::byte> data) = 0;
  /// Flushes all written data to the device, and closes the file.
  virtual void finish() = 0;

 protected:
  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(mode_ == Mode::kRead ? ExitCode::kInput : ExitCode::kOutput, name_ + ": " + reason);
  }

 private:
  std::string name_;
  Mode mode_;
};

/// Opens an existing file. `name` is what errors call it.
///
/// POSIX pread and pwrite by default. MPI-IO (MPI_File on MPI_COMM_SELF) when the environment has SKEIN_IO=mpi.
/// Measured with Open MPI 4.1.4 (OMPIO), 2 and 4 ranks: both reach the same speed when each rank writes its own slice
/// (2.7-3.5 GB/s), MPI_File_open takes 100 times as long (0.5 ms), and on a full device MPI_File_write_at returns
/// MPI_SUCCESS with a short or zero count, drops what still had room, and prints a line of its own; the reason (errno)
/// is lost. And MPI_File_close on a communicator of all ranks is collective: one rank's exception would hang there.
std::unique_ptr<RawFile> open_raw(const std::string& path, const std::string& name, RawFile::Mode mode);

}  // namespace skein::detail
