// Work in an OpenMP region, whatever number of threads OpenMP gives: ctest runs this program in several environments.
#include "base/parallel.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>

namespace skein::test {
namespace {

TEST(InParallel, DoesEachShareOnce) {
  for (int threads = 1; threads <= 9; ++threads) {
    std::vector<int> times(static_cast<std::size_t>(threads), 0);
    in_parallel(threads, [&](int w) { ++times[static_cast<std::size_t>(w)]; });
    EXPECT_EQ(times, std::vector<int>(times.size(), 1)) << threads;
  }
}

TEST(InParallel, TheCallerDoesTheFirstShare) {
  std::thread::id first;
  in_parallel(4, [&](int w) {
    if (w == 0) first = std::this_thread::get_id();
  });
  EXPECT_EQ(first, std::this_thread::get_id());
}

TEST(InParallel, ThrowsTheFirstExceptionWhenAllHaveEnded) {
  std::vector<int> done(6, 0);
  const auto work = [&](int w) {
    done[static_cast<std::size_t>(w)] = 1;
    if (w == 2 || w == 4) throw std::runtime_error(std::to_string(w));
  };
  try {
    in_parallel(6, work);
    ADD_FAILURE() << "no exception";
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "2");
  }
  EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), 6);
}

TEST(InParallel, InsideAnotherGivesTheSame) {
  constexpr int kOuter = 3, kInner = 4;
  std::vector<int> got(kOuter * kInner, -1);
  in_parallel(kOuter, [&](int a) {
    in_parallel(kInner, [&](int b) { got[static_cast<std::size_t>(kInner * a + b)] = kInner * a + b; });
  });
  std::vector<int> want(got.size());
  std::iota(want.begin(), want.end(), 0);
  EXPECT_EQ(got, want);
}

TEST(InParallel, KeepsToTheLimitOfTheEnvironment) {
  const char* const limit = std::getenv("OMP_THREAD_LIMIT");
  if (limit == nullptr) GTEST_SKIP() << "OMP_THREAD_LIMIT is not set";
  std::vector<int> there(4, 0);
  in_parallel(4, [&](int w) { there[static_cast<std::size_t>(w)] = omp_get_num_threads(); });
  EXPECT_EQ(there, std::vector<int>(there.size(), std::atoi(limit)));
}

}  // namespace
}  // namespace skein::test
