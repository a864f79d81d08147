// Order statistics over ranks are those of the sorted whole.
#include "report/order_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "tests/support/world.hpp"

namespace skein {
namespace {

/// The same n numbers on every rank, over many magnitudes, with zeros and repetitions.
std::vector<double> sample(std::size_t n) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-30, 30);
  std::vector<double> v(n);
  for (std::size_t i = 0; i < n; ++i) v[i] = i % 7 == 0 ? 0.0 : i % 5 == 0 ? 1.5 : std::exp2(exponent(random));
  if (n > 3) v[3] = -0.0;
  return v;
}

TEST(OrderStatistics, AreThoseOfTheSortedWhole) {
  const Comm& comm = test::world();
  const std::vector<double> all = sample(1001);
  std::vector<double> mine, sorted = all;
  for (std::size_t i = 0; i < all.size(); ++i) {  // uneven: rank 0 has more than half
    const std::size_t owner = i % 2 == 0 ? 0 : i % static_cast<std::size_t>(comm.size());
    if (owner == idx(comm.rank())) mine.push_back(all[i]);
  }
  std::sort(sorted.begin(), sorted.end());
  const std::vector<std::int64_t> ks{0, 1, 10, 142, 143, 144, 500, 999, 1000};
  const std::span<const double> whole(mine);
  for (const std::size_t cut : {std::size_t{0}, mine.size() / 3, mine.size()}) {  // in two pieces
    const std::array pieces{whole.first(cut), whole.subspan(cut)};
    const std::vector<double> found = order_statistics(comm, pieces, ks);
    for (std::size_t i = 0; i < ks.size(); ++i) EXPECT_EQ(found[i], sorted[ks[i]]) << ks[i];
  }
}

TEST(OrderStatistics, OfOneNumberOnTheLastRank) {
  const Comm& comm = test::world();
  std::vector<double> mine;
  if (num(comm.rank()) == comm.size() - 1) mine.push_back(0.25);
  const std::array pieces{std::span<const double>(mine)};
  EXPECT_EQ(order_statistics(comm, pieces, std::vector<std::int64_t>{0}).at(0), 0.25);
}

TEST(OrderStatistics, PercentileIndexStaysInside) {
  EXPECT_EQ(percentile_index(0, 10), 0);
  EXPECT_EQ(percentile_index(1, 1000), 10);
  EXPECT_EQ(percentile_index(99, 1), 0);
  EXPECT_EQ(percentile_index(100, 10), 9);
}

}  // namespace
}  // namespace skein
