// main() of tests on several ranks: rank 0 prints as usual, the other ranks only what fails.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "tests/support/world.hpp"

namespace skein::test {
namespace {

const Comm* all_ranks = nullptr;

/// Prints the failures of one rank, and nothing else.
class FailurePrinter : public ::testing::EmptyTestEventListener {
 public:
  explicit FailurePrinter(Rank rank) : rank_(num(rank)) {}
  void OnTestPartResult(const ::testing::TestPartResult& r) override {
    if (!r.failed()) return;
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::fprintf(stderr, "[rank %d] %s.%s %s:%d\n%s\n", rank_, info != nullptr ? info->test_suite_name() : "-",
                 info != nullptr ? info->name() : "-", r.file_name() != nullptr ? r.file_name() : "?", r.line_number(),
                 r.message());
    std::fflush(stderr);
  }

 private:
  int rank_;
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
