// InputFile and OutputFile: what is checked, and when a file gets its name.
#include "comm/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "comm/raw_file.hpp"

namespace skein {
namespace {

namespace fs = std::filesystem;
using detail::RawFile;

[[noreturn]] void fail(ExitCode code, const std::string& path, const std::string& what) {
  throw Error(code, fmt::format("{}: {}", path, what));
}
std::string reason() { return std::strerror(errno); }

/// The size of an existing file that can be read at any place.
std::int64_t regular_size(const std::string& path, ExitCode code) {
  struct stat s {};
  if (::stat(path.c_str(), &s) != 0) {
    if (errno == ENOENT) fail(code, path, "no such file; check the path");
    fail(code, path, "cannot be opened: " + reason());
  }
  if (S_ISDIR(s.st_mode)) fail(code, path, "is a folder, not a file");
  if (!S_ISREG(s.st_mode)) fail(code, path, "is not a regular file");
  return s.st_size;
}

/// The file that `path` means: links are followed, so that commit() replaces the file and not the link to it.
fs::path output_target(const std::string& path) {
  if (path.empty()) throw Error(ExitCode::kOutput, "the name of an output file is empty");
  std::error_code e;
  fs::path target = path;
  for (int hops = 0; fs::is_symlink(target, e); ++hops) {  // also links whose file does not exist yet
    if (hops == 40) fail(ExitCode::kOutput, path, "cannot be written: too many links");
    const fs::path next = fs::read_symlink(target, e);
    if (e) fail(ExitCode::kOutput, path, "cannot be written: " + e.message());
    target = target.parent_path() / next;  // an absolute `next` replaces all
  }
  if (fs::exists(target, e)) regular_size(target.string(), ExitCode::kOutput);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, e))
    fail(ExitCode::kOutput, path, fmt::format("the folder {} does not exist; create it first", folder.string()));
  if (!target.has_filename()) fail(ExitCode::kOutput, path, "is a folder, not a file");
  return target;
}

/// Creates an empty file beside the target; a name that is taken is not touched.
std::string create_temporary(const std::string& path, const fs::path& target) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    const std::string tail = attempt == 0 ? "tmp" : fmt::format("{}.tmp", attempt);
    const std::string name = fmt::format(".{}.{}.{}", target.filename().string(), ::getpid(), tail);
    std::string temporary = (target.parent_path() / name).string();
    const int fd = ::open(temporary.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (fd >= 0) {
      ::close(fd);
      return temporary;
    }
    if (errno != EEXIST) break;
  }
  fail(ExitCode::kOutput, path, "cannot be created: " + reason());
}

}  // namespace

Slice even_slice(std::int64_t n, Rank r, int ranks) noexcept {
  // 128 bits: n * ranks may be beyond 64.
  const auto start = [&](std::int64_t i) { return static_cast<std::int64_t>(static_cast<__int128>(n) * i / ranks); };
  return {start(num(r)), start(std::int64_t{num(r)} + 1)};
}

Rank slice_owner(std::int64_t n, std::int64_t i, int ranks) noexcept {
  // The largest r with n*r/P <= i, that is n*r < (i+1)*P.
  const __int128 bound = static_cast<__int128>(i + 1) * ranks - 1;
  return to_id<Rank>(static_cast<std::int64_t>(bound / n));
}

struct InputFile::Impl {
  std::string path;
  std::int64_t size = 0;
  std::unique_ptr<RawFile> file;
};

InputFile::InputFile(const Comm& comm, const std::string& path) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  agree(comm, [&] {
    impl->size = regular_size(path, ExitCode::kInput);
    impl->file = detail::open_raw(path, path, RawFile::Mode::kRead);
  });
  impl_ = std::move(impl);
}

InputFile::~InputFile() = default;

std::int64_t InputFile::size() const noexcept { return impl_->size; }

void InputFile::read(std::int64_t at, std::span<std::byte> out) const {
  if (impl_->file->read(at, out) == out.size()) return;
  fail(ExitCode::kInput, impl_->path,
       fmt::format("truncated: {} bytes wanted from byte {}, but it has {} bytes; is the file complete?", out.size(),
                   at, impl_->size));
}

namespace {

/// The names of temporary files where a signal handler finds them. Files beyond the last slot are left behind then.
struct Slot {
  std::atomic<bool> taken = false, filled = false;
  std::array<char, 4096> path{};
};
std::array<Slot, 8> slots;

Slot* remember(const std::string& path) noexcept {
  if (path.size() >= Slot{}.path.size()) return nullptr;
  for (Slot& s : slots) {
    if (s.taken.exchange(true)) continue;
    std::copy(path.begin(), path.end(), s.path.begin());
    s.path[path.size()] = '\0';
    s.filled = true;
    return &s;
  }
  return nullptr;
}

void forget(Slot* slot) noexcept {
  if (slot == nullptr) return;
  slot->filled = false;
  slot->taken = false;
}

}  // namespace

void remove_temporary_files() noexcept {
  for (Slot& s : slots) {
    if (s.filled) ::unlink(s.path.data());
  }
}

struct OutputFile::Impl {
  Impl(const Comm& c, std::string p) : comm(c), path(std::move(p)) {}
  ~Impl() {
    file.reset();
    forget(slot);
    if (comm.is_root() && !committed && !temporary.empty()) ::unlink(temporary.c_str());
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const Comm& comm;
  std::string path;
  fs::path target;        // rank 0
  std::string temporary;  // empty until it exists
  Slot* slot = nullptr;   // rank 0
  std::unique_ptr<RawFile> file;
  std::int64_t end = 0;  // one past the last byte that this rank wrote
  bool failed = false;
  bool committed = false;
};

OutputFile::OutputFile(const Comm& comm, const std::string& path) {
  auto impl = std::make_unique<Impl>(comm, path);
  agree(comm, [&] {
    if (!comm.is_root()) return;
    impl->target = output_target(path);
    impl->temporary = create_temporary(path, impl->target);
    impl->slot = remember(impl->temporary);
  });
  impl->temporary = comm.broadcast(impl->temporary);
  agree(comm, [&] { impl->file = detail::open_raw(impl->temporary, path, RawFile::Mode::kWrite); });
  impl_ = std::move(impl);
}

OutputFile::~OutputFile() = default;

void OutputFile::write(std::int64_t at, std::span<const std::byte> data) {
  if (impl_->file == nullptr) fail(ExitCode::kInternal, impl_->path, "written after commit");
  impl_->failed = true;
  impl_->file->write(at, data);
  impl_->failed = false;
  impl_->end = std::max(impl_->end, at + static_cast<std::int64_t>(data.size()));
}

void OutputFile::commit() {
  agree(impl_->comm, [&] {
    if (impl_->file == nullptr) fail(ExitCode::kInternal, impl_->path, "committed twice");
    if (impl_->failed) fail(ExitCode::kOutput, impl_->path, "an earlier write has failed");
    impl_->file->finish();
    impl_->file.reset();
  });
  const std::int64_t end = impl_->comm.max(impl_->end);
  agree(impl_->comm, [&] {
    if (!impl_->comm.is_root()) return;
    if (regular_size(impl_->temporary, ExitCode::kOutput) != end)
      fail(ExitCode::kOutput, impl_->path, "not everything was written; is the device full?");
    if (::rename(impl_->temporary.c_str(), impl_->target.c_str()) != 0)
      fail(ExitCode::kOutput, impl_->path, "cannot be given its name: " + reason());
  });
  impl_->committed = true;
}

}  // namespace skein
