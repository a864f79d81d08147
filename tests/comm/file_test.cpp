// Files in slices: round trips, and one clear error on all ranks.
#include "comm/file.hpp"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/world.hpp"

namespace skein {
namespace {

namespace fs = std::filesystem;
using test::world;

/// A folder of this run, removed at the end of the test. Collective.
class Folder {
 public:
  Folder() {
    path_ = world().broadcast((fs::temp_directory_path() / ("skein_test_file." + std::to_string(::getpid()))).string());
    if (world().is_root()) fs::create_directory(path_);
    world().barrier();
  }
  ~Folder() {
    world().barrier();
    std::error_code e;
    if (world().is_root()) fs::remove_all(path_, e);
  }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }

 private:
  std::string path_;
};

std::byte byte_at(std::int64_t i) { return static_cast<std::byte>((i * 7 + i / 251) & 0xff); }

void write_slice(OutputFile& file, std::int64_t n) {
  const Slice s = even_slice(n, world().rank(), world().size());
  std::vector<std::byte> data;
  for (std::int64_t i = s.first; i < s.last; ++i) data.push_back(byte_at(i));
  file.write(s.first, data);
}

/// Code and line of the error of `work`, which all ranks must have alike.
template <class F>
std::pair<ExitCode, std::string> error_of(F work) {
  std::pair<ExitCode, std::string> got{ExitCode::kOk, ""};
  try {
    work();
  } catch (const Error& e) {
    got = {e.code(), e.what()};
  }
  EXPECT_EQ(world().broadcast(got.second), got.second);
  return got;
}
bool contains(const std::string& s, const std::string& part) { return s.find(part) != std::string::npos; }

TEST(Slices, cover_everything_once_and_know_their_owner) {
  for (const std::int64_t n : {std::int64_t{1}, std::int64_t{3}, std::int64_t{100}, std::int64_t{1} << 61}) {
    for (const int ranks : {1, 2, 3, 7, 1000}) {
      std::int64_t next = 0;
      for (int r = 0; r < ranks; ++r) {
        const Slice s = even_slice(n, Rank{r}, ranks);
        EXPECT_EQ(s.first, next);
        next = s.last;
        if (s.size() == 0) continue;
        EXPECT_EQ(slice_owner(n, s.first, ranks), Rank{r});
        EXPECT_EQ(slice_owner(n, s.last - 1, ranks), Rank{r});
      }
      EXPECT_EQ(next, n);
    }
  }
}

class Files : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { ::setenv("SKEIN_IO", GetParam(), 1); }
  void TearDown() override { ::unsetenv("SKEIN_IO"); }
};
INSTANTIATE_TEST_SUITE_P(Ways, Files, ::testing::Values("posix", "mpi"));

TEST_P(Files, written_in_slices_and_read_back_by_all) {
  const Folder folder;
  for (const std::int64_t n : {std::int64_t{0}, std::int64_t{3}, std::int64_t{100003}}) {
    {
      OutputFile file(world(), folder / "mesh");
      write_slice(file, n);
      EXPECT_EQ(fs::exists(folder / "mesh"), n != 0) << "the name appears at the commit";
      file.commit();
    }
    world().barrier();
    const InputFile file(world(), folder / "mesh");
    EXPECT_EQ(file.size(), n);
    std::vector<std::byte> data(static_cast<std::size_t>(n));
    file.read(0, data);
    std::int64_t wrong = 0;
    for (std::int64_t i = 0; i < n; ++i) wrong += data[i] != byte_at(i);
    EXPECT_EQ(wrong, 0);
    world().barrier();
    EXPECT_EQ(folder.files(), 1U) << "no temporary file stays";
    world().barrier();
  }
}

TEST_P(Files, without_commit_the_old_file_stays) {
  const Folder folder;
  if (world().is_root()) std::ofstream(folder / "mesh") << "old";
  world().barrier();
  EXPECT_THROW(
      {
        OutputFile file(world(), folder / "mesh");
        write_slice(file, 1000);
        throw std::runtime_error("unwinding");
      },
      std::runtime_error);
  world().barrier();
  EXPECT_EQ(folder.files(), 1U);
  EXPECT_EQ(fs::file_size(folder / "mesh"), 3U);
  world().barrier();
  OutputFile file(world(), folder / "mesh");
  write_slice(file, 1000);
  file.commit();
  EXPECT_EQ(fs::file_size(folder / "mesh"), 1000U);
}

TEST_P(Files, reading_beyond_the_end_is_an_error) {
  const Folder folder;
  if (world().is_root()) std::ofstream(folder / "mesh") << "0123456789";
  world().barrier();
  const InputFile file(world(), folder / "mesh");
  std::vector<std::byte> data(4);
  file.read(6, data);
  EXPECT_EQ(static_cast<char>(data[3]), '9');
  const auto e = error_of([&] { file.read(7, data); });
  EXPECT_EQ(e.first, ExitCode::kInput);
  EXPECT_TRUE(contains(e.second, "truncated")) << e.second;
  EXPECT_TRUE(contains(e.second, folder / "mesh")) << e.second;
}

TEST_P(Files, inputs_that_cannot_be_read) {
  const Folder folder;
  const auto missing = error_of([&] { InputFile(world(), folder / "nothing"); });
  EXPECT_EQ(missing.first, ExitCode::kInput);
  EXPECT_TRUE(contains(missing.second, folder / "nothing" + ": no such file")) << missing.second;
  const auto is_folder = error_of([&] { InputFile(world(), folder.path()); });
  EXPECT_EQ(is_folder.first, ExitCode::kInput);
  EXPECT_TRUE(contains(is_folder.second, "is a folder")) << is_folder.second;
  EXPECT_TRUE(contains(error_of([&] { InputFile(world(), "/dev/null"); }).second, "not a regular file"));
  EXPECT_EQ(error_of([&] { InputFile(world(), ""); }).first, ExitCode::kInput);
}

TEST_P(Files, outputs_that_cannot_be_written) {
  const Folder folder;
  const auto no_folder = error_of([&] { OutputFile(world(), folder / "no/mesh"); });
  EXPECT_EQ(no_folder.first, ExitCode::kOutput);
  EXPECT_TRUE(contains(no_folder.second, "does not exist")) << no_folder.second;
  EXPECT_TRUE(contains(error_of([&] { OutputFile(world(), folder.path()); }).second, "is a folder"));
  EXPECT_TRUE(contains(error_of([&] { OutputFile(world(), folder.path() + "/"); }).second, "is a folder"));
  EXPECT_TRUE(contains(error_of([&] { OutputFile(world(), "/dev/null"); }).second, "not a regular file"));
  EXPECT_EQ(error_of([&] { OutputFile(world(), ""); }).first, ExitCode::kOutput);
  EXPECT_EQ(error_of([&] { OutputFile(world(), folder / std::string(300, 'x')); }).first, ExitCode::kOutput);
  EXPECT_EQ(error_of([&] { OutputFile(world(), "/proc/mesh"); }).first, ExitCode::kOutput);
  EXPECT_EQ(folder.files(), 0U);
}

TEST_P(Files, a_link_is_followed) {
  const Folder folder;
  if (world().is_root()) fs::create_symlink("real", folder / "link");
  world().barrier();
  OutputFile file(world(), folder / "link");
  write_slice(file, 10);
  file.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(fs::file_size(folder / "real"), 10U);
}

TEST(Permissions, unreadable_and_read_only) {
  const Folder folder;
  if (world().is_root()) {
    std::ofstream(folder / "secret") << "x";
    fs::create_directory(folder / "locked");
    fs::permissions(folder / "secret", fs::perms::none);
    fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  }
  world().barrier();
  // root may do everything; become somebody else for the calls (0777 on the folder above keeps it reachable).
  const bool root = ::geteuid() == 0;
  if (root && ::seteuid(65534) != 0) std::abort();
  const auto secret = error_of([&] { InputFile(world(), folder / "secret"); });
  const auto locked = error_of([&] { OutputFile(world(), folder / "locked/mesh"); });
  if (root && ::seteuid(0) != 0) std::abort();
  EXPECT_EQ(secret.first, ExitCode::kInput);
  EXPECT_TRUE(contains(secret.second, "Permission denied")) << secret.second;
  EXPECT_EQ(locked.first, ExitCode::kOutput);
  EXPECT_TRUE(contains(locked.second, "Permission denied")) << locked.second;
}

TEST_P(Files, a_full_device_is_reported_and_leaves_nothing) {
  const Folder folder;
  std::int32_t mounted = 0;
  if (world().is_root()) mounted = ::mount("none", folder.path().c_str(), "tmpfs", 0, "size=64k") == 0 ? 1 : 0;
  if (world().max(mounted) == 0) GTEST_SKIP() << "cannot mount a small device";
  std::int32_t failed = 0;
  const auto e = error_of([&] {
    OutputFile file(world(), folder / "mesh");
    try {
      write_slice(file, 1 << 20);
    } catch (const Error& write_error) {
      EXPECT_EQ(write_error.code(), ExitCode::kOutput);
      failed = 1;
    }
    file.commit();
  });
  EXPECT_EQ(world().max(failed), 1);
  EXPECT_EQ(e.first, ExitCode::kOutput);
  world().barrier();
  EXPECT_EQ(folder.files(), 0U);
  world().barrier();
  if (world().is_root()) ::umount(folder.path().c_str());
}

}  // namespace
}  // namespace skein
