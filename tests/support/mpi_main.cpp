// main() of tests on several ranks: rank 0 prints as usual, the other ranks only what fails.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <string>

#include "tests/support/world.hpp"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace skein::test {
namespace {

const Comm* all_ranks = nullptr;

/// Prints the failures of one rank, and nothing else.
class FailurePrinter : public ::testing::EmptyTestEventListener {
 public:
  explicit FailurePrinter(Rank rank) : rank_(num(rank)) {}
  void OnTestStart(const ::testing::TestInfo& info) override {
    name_ = std::string(info.test_suite_name()) + "." + info.name();
  }
  void OnTestPartResult(const ::testing::TestPartResult& r) override {  // must not ask UnitTest: it holds its lock
    if (!r.failed()) return;
    std::fprintf(stderr, "[rank %d] %s %s:%d\n%s\n", rank_, name_.c_str(),
                 r.file_name() != nullptr ? r.file_name() : "?", r.line_number(), r.message());
    std::fflush(stderr);
  }

 private:
  int rank_;
  std::string name_;
};

/// With the leak sanitizer: looks for leaks before MPI ends, because then it forgets much of its own memory (the tests
/// run with leak_check_at_exit=0).
bool leaks_memory() {
#if defined(__SANITIZE_ADDRESS__)
  return __lsan_do_recoverable_leak_check() != 0;
#else
  return false;
#endif
}

}  // namespace

const Comm& world() noexcept { return *all_ranks; }

}  // namespace skein::test

int main(int argc, char** argv) {
#if defined(__SANITIZE_ADDRESS__)
  __lsan_disable();  // what MPI allocates as it starts is not ours
#endif
  const skein::Environment environment(argc, argv);
#if defined(__SANITIZE_ADDRESS__)
  __lsan_enable();
#endif
  ::testing::InitGoogleTest(&argc, argv);
  const skein::Comm world = skein::Comm::world();
  skein::test::all_ranks = &world;
  if (!world.is_root()) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    const std::unique_ptr<::testing::TestEventListener> usual(listeners.Release(listeners.default_result_printer()));
    auto printer = std::make_unique<skein::test::FailurePrinter>(world.rank());
    listeners.Append(printer.release());  // which owns it from now on
  }
  std::int32_t failed = RUN_ALL_TESTS();
  if (skein::test::leaks_memory()) failed = 1;
  return world.max(failed);
}
