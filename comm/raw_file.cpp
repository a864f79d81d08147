// RawFile over POSIX, and over MPI-IO.
#include "comm/raw_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "comm/impl.hpp"

namespace skein::detail {
namespace {

class PosixFile final : public RawFile {
 public:
  PosixFile(const std::string& path, const std::string& name, Mode mode) : RawFile(name, mode) {
    fd_ = ::open(path.c_str(), (mode == Mode::kRead ? O_RDONLY : O_WRONLY) | O_CLOEXEC);
    if (fd_ < 0) fail(std::string("cannot be opened: ") + std::strerror(errno));
  }
  ~PosixFile() override {
    if (fd_ >= 0) ::close(fd_);
  }

  std::size_t read(std::int64_t at, std::span<std::byte> out) override {
    std::size_t done = 0;
    while (done < out.size()) {
      const ssize_t n =
          ::pread(fd_, out.data() + done, std::min(out.size() - done, kChunk), at + static_cast<std::int64_t>(done));
      if (n == 0) break;
      if (n < 0 && errno != EINTR) fail(std::string("cannot be read: ") + std::strerror(errno));
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    return done;
  }

  void write(std::int64_t at, std::span<const std::byte> data) override {
    std::size_t done = 0;
    while (done < data.size()) {
      const ssize_t n =
          ::pwrite(fd_, data.data() + done, std::min(data.size() - done, kChunk), at + static_cast<std::int64_t>(done));
      if (n < 0 && errno != EINTR) fail(std::string("cannot be written: ") + std::strerror(errno));
      if (n > 0) done += static_cast<std::size_t>(n);
    }
#ifdef SYNC_FILE_RANGE_WRITE
    // The device begins while the next piece is made ready; finish() waits for all. Not needed for anything else, so it
    // may fail.
    ::sync_file_range(fd_, at, static_cast<off64_t>(data.size()), SYNC_FILE_RANGE_WRITE);
#endif
  }

  void finish() override {
    const bool synced = ::fsync(fd_) == 0 || errno == EINVAL;  // EINVAL: a file system without sync
    const int reason = errno;
    const bool closed = ::close(fd_) == 0;
    fd_ = -1;
    if (!synced || !closed) fail(std::string("cannot be written: ") + std::strerror(synced ? errno : reason));
  }

 private:
  int fd_ = -1;
};

class MpiFile final : public RawFile {
 public:
  MpiFile(const std::string& path, const std::string& name, Mode mode) : RawFile(name, mode) {
    const int flags = mode == Mode::kRead ? MPI_MODE_RDONLY : MPI_MODE_WRONLY;
    check(MPI_File_open(MPI_COMM_SELF, path.c_str(), flags, MPI_INFO_NULL, &file_), "cannot be opened: ");
    MPI_File_set_errhandler(file_, MPI_ERRORS_RETURN);
  }
  ~MpiFile() override {
    if (file_ != MPI_FILE_NULL) MPI_File_close(&file_);
  }

  std::size_t read(std::int64_t at, std::span<std::byte> out) override {
    std::size_t done = 0;
    for_chunks(out.size(), [&](std::size_t first, int n) {
      if (done < first) return;  // the file has ended
      MPI_Status status;
      check(MPI_File_read_at(file_, at + static_cast<std::int64_t>(first), out.data() + first, n, MPI_BYTE, &status),
            "cannot be read: ");
      done += count(status);
    });
    return done;
  }

  void write(std::int64_t at, std::span<const std::byte> data) override {
    for_chunks(data.size(), [&](std::size_t first, int n) {
      MPI_Status status;
      check(MPI_File_write_at(file_, at + static_cast<std::int64_t>(first), data.data() + first, n, MPI_BYTE, &status),
            "cannot be written: ");
      if (count(status) != static_cast<std::size_t>(n)) fail("cannot be written: is the device full?");
    });
  }

  void finish() override {
    const int synced = MPI_File_sync(file_);
    check(MPI_File_close(&file_), "cannot be written: ");
    check(synced, "cannot be written: ");
  }

 private:
  void check(int result, const char* what) const {
    if (result == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(result, text, &length);
    fail(what + std::string(text));
  }
  static std::size_t count(const MPI_Status& status) {
    int n = 0;
    MPI_Get_count(&status, MPI_BYTE, &n);
    return n == MPI_UNDEFINED ? 0 : static_cast<std::size_t>(n);
  }
  MPI_File file_ = MPI_FILE_NULL;
};

}  // namespace

std::unique_ptr<RawFile> open_raw(const std::string& path, const std::string& name, RawFile::Mode mode) {
  const char* choice = std::getenv("SKEIN_IO");
  if (choice != nullptr && std::string(choice) == "mpi") return std::make_unique<MpiFile>(path, name, mode);
  return std::make_unique<PosixFile>(path, name, mode);
}

}  // namespace skein::detail
