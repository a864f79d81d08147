// Spacing of sources: distances against brute force, and the shape of eq. 35.2.
#include "metric/spacing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace skein {
namespace {

class Points {
 public:
  Vec3 next() { return {number_(random_), number_(random_), number_(random_)}; }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> number_{-1, 1};
};

/// Least distance to points of the source on a grid; at most `step` too large.
double brute_force(const Source& s, Vec3 x, int n) {
  double best = 1e300;
  for (int i = 0; i <= n; ++i) {
    for (int k = 0; k <= n - i; ++k) {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(k) / n;
      const Vec3 p = s.corners == 1   ? s.corner[0]
                     : s.corners == 2 ? s.corner[0] + u * (s.corner[1] - s.corner[0])
                                      : s.corner[0] + u * (s.corner[1] - s.corner[0]) + v * (s.corner[2] - s.corner[0]);
      best = std::min(best, norm(x - p));
    }
  }
  return best;
}

TEST(SourceDistance, IsThatOfTheNearestPoint) {
  Points points;
  constexpr int kSteps = 400;
  for (int corners = 1; corners <= 3; ++corners) {
    for (int trial = 0; trial < 20; ++trial) {
      const Source s{corners, {points.next(), points.next(), points.next()}, 1, 0, 1};
      const Vec3 x = 1.5 * points.next();
      const double found = distance(s, x), sampled = brute_force(s, x, kSteps);
      EXPECT_LE(found, sampled * (1 + 1e-12));
      EXPECT_GE(found, sampled - 8.0 / kSteps);  // sides are shorter than 4
    }
  }
}

TEST(SourceDistance, IsZeroOnTheSource) {
  Points points;
  for (int trial = 0; trial < 20; ++trial) {
    const Source s{3, {points.next(), points.next(), points.next()}, 1, 0, 1};
    EXPECT_NEAR(distance(s, (1.0 / 3.0) * (s.corner[0] + s.corner[1] + s.corner[2])), 0, 1e-14);
    EXPECT_NEAR(distance(s, 0.5 * (s.corner[0] + s.corner[2])), 0, 1e-14);
    EXPECT_NEAR(distance(s, s.corner[1]), 0, 1e-15);
  }
}

TEST(SourceDistance, OfAFlatTriangleIsThatOfItsSides) {
  const Source flat{3, {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{3, 0, 0}}, 1, 0, 1};
  EXPECT_DOUBLE_EQ(distance(flat, {2, 1, 0}), 1);
  EXPECT_DOUBLE_EQ(distance(flat, {4, 0, 0}), 1);
  const Source dot{3, {Vec3{1, 1, 1}, Vec3{1, 1, 1}, Vec3{1, 1, 1}}, 1, 0, 1};
  EXPECT_DOUBLE_EQ(distance(dot, {1, 1, 3}), 2);
}

TEST(SpacingField, IsConstantInsideR1AndDoublesAtR2) {
  SpacingField f;
  f.sources.push_back({1, {Vec3{1, 2, 3}, {}, {}}, 0.1, 0.5, 0.8});
  const auto at = [&](double d) { return f.at({1 + d, 2, 3}); };
  EXPECT_EQ(at(0), 0.1);
  EXPECT_EQ(at(0.49), 0.1);
  EXPECT_NEAR(at(0.5), 0.1, 1e-14);
  EXPECT_NEAR(at(0.8), 0.2, 1e-14);
  EXPECT_NEAR(at(1.1), 0.4, 1e-14);
  for (double d = 0; d < 3; d += 0.05) EXPECT_LE(at(d), at(d + 0.05));
}

TEST(SpacingField, TakesTheStrictestSource) {
  Points points;
  SpacingField f;
  f.size_max = 0.7;
  for (int corners = 1; corners <= 3; ++corners) {
    f.sources.push_back({corners, {points.next(), points.next(), points.next()}, 0.1 * corners, 0.05, 0.4});
  }
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 x = 2 * points.next();
    double least = f.size_max;
    for (const Source& s : f.sources) least = std::min(least, SpacingField{{s}, 1e300}.at(x));
    EXPECT_EQ(f.at(x), least);
    EXPECT_LE(f.at(x), 0.7);
  }
  EXPECT_EQ(f.at({1e9, 0, 0}), 0.7);  // far away the exponential overflows
}

}  // namespace
}  // namespace skein
