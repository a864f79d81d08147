// The Hilbert curve visits every cell once, from neighbour to neighbour.
#include "base/hilbert.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

namespace skein::test {
namespace {

struct Cell {
  std::uint64_t key;
  std::array<int, 3> at;
};

/// The cells of a grid of 2^bits cells per axis, in the order of the curve. Their keys differ in the highest 3*bits
/// bits.
std::vector<Cell> curve(int bits, const Box& box) {
  const int n = 1 << bits;
  std::vector<Cell> cells;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const auto middle = [&](double low, double high, int c) { return low + (high - low) * (c + 0.5) / n; };
        const Vec3 x{middle(box.low.x, box.high.x, i), middle(box.low.y, box.high.y, j),
                     middle(box.low.z, box.high.z, k)};
        cells.push_back({hilbert_key(x, box) >> (63 - 3 * bits), {i, j, k}});
      }
    }
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
  return cells;
}

TEST(Hilbert, IsABijectionThatStepsToNeighbours) {
  for (int bits = 1; bits <= 5; ++bits) {
    for (const Box& box : {Box{{0, 0, 0}, {1, 1, 1}}, Box{{-3, 1e-3, 100}, {5, 2e-3, 1e4}}}) {
      const auto cells = curve(bits, box);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        ASSERT_EQ(cells[i].key, i);
        if (i == 0) continue;
        int steps = 0;
        for (std::size_t a = 0; a < 3; ++a) steps += std::abs(cells[i].at[a] - cells[i - 1].at[a]);
        ASSERT_EQ(steps, 1);
      }
    }
  }
}

TEST(Hilbert, PointsOutsideGoToTheBorder) {
  const Box box{{0, 0, 0}, {1, 2, 3}};
  EXPECT_EQ(hilbert_key({-5, 1, 1}, box), hilbert_key({0, 1, 1}, box));
  EXPECT_EQ(hilbert_key({7, 9, 11}, box), hilbert_key({1, 2, 3}, box));
  EXPECT_LT(hilbert_key({1, 2, 3}, box), 1ULL << 63);
}

TEST(Hilbert, FlatBoxesAreFine) {
  const Box box{{0, 0, 2}, {1, 1, 2}};
  EXPECT_NE(hilbert_key({0.1, 0.1, 2}, box), hilbert_key({0.9, 0.9, 2}, box));
}

}  // namespace
}  // namespace skein::test
