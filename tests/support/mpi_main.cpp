// main() of tests on several ranks: rank 0 prints as usual, the other ranks only what fails.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "tests/support/world.hpp"

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

}  // namespace

const Comm& world() noexcept { return *all_ranks; }

}  // namespace skein::test

int main(int argc, char** argv) {
  const skein::Environment environment(argc, argv);
  ::testing::InitGoogleTest(&argc, argv);
  const skein::Comm world = skein::Comm::world();
  skein::test::all_ranks = &world;
  if (!world.is_root()) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new skein::test::FailurePrinter(world.rank()));
  }
  const std::int32_t failed = RUN_ALL_TESTS();
  return world.max(failed);
}
