// orient3d_sign is exact: compared with integers, and by its symmetries where points are degenerate.
#include "mesh/predicates.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>

namespace skein::test {
namespace {

using Points = std::array<Vec3, 4>;
int sign(const Points& p) { return orient3d_sign(p[0], p[1], p[2], p[3]); }

/// Every permutation gives the sign of the permutation.
void expect_antisymmetric(const Points& p) {
  std::array<std::size_t, 4> order{0, 1, 2, 3};
  const int s = sign(p);
  RC_ASSERT(s == orient3d_exact(p[0], p[1], p[2], p[3]));
  do {
    int inversions = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
    }
    const int is = sign({p[order[0]], p[order[1]], p[order[2]], p[order[3]]});
    RC_ASSERT(is == (inversions % 2 == 0 ? s : -s));
  } while (std::next_permutation(order.begin(), order.end()));
}

/// The sign over integers of up to 37 bits, which are exact in 128 bits.
int integer_sign(const std::array<std::array<std::int64_t, 3>, 4>& p) {
  using Wide = __int128;
  std::array<std::array<Wide, 3>, 3> d;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) d[i][k] = p[i + 1][k] - p[0][k];
  }
  const Wide det = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                   d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                   d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return (det > 0) - (det < 0);
}

RC_GTEST_PROP(Orient3d, IsExactNearAPlane, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  const auto any = [&](int bits) { return static_cast<std::int64_t>(random() >> (64 - bits)) - (1LL << (bits - 1)); };
  const int bits = *rc::gen::inRange(2, 19);
  // d = a + i (b - a) + j (c - a) is in the plane of a, b, c; then it is moved by a unit, or not.
  std::array<std::array<std::int64_t, 3>, 4> p;
  for (std::size_t v = 0; v < 3; ++v) {
    for (auto& x : p[v]) x = any(bits);
  }
  const std::int64_t i = any(bits), j = any(bits);
  for (std::size_t k = 0; k < 3; ++k) p[3][k] = p[0][k] + i * (p[1][k] - p[0][k]) + j * (p[2][k] - p[0][k]);
  p[3][random() % 3] += static_cast<std::int64_t>(random() % 3) - 1;
  Points x;
  for (std::size_t v = 0; v < 4; ++v) {
    x[v] = {static_cast<double>(p[v][0]), static_cast<double>(p[v][1]), static_cast<double>(p[v][2])};
  }
  RC_ASSERT(sign(x) == integer_sign(p));
  expect_antisymmetric(x);
  const double scale = *rc::gen::element(0x1p-300, 0x1p-40, 0x1p40, 0x1p200);
  for (auto& v : x) v = scale * v;
  RC_ASSERT(sign(x) == integer_sign(p));
}

RC_GTEST_PROP(Orient3d, IsAntisymmetricOnRoundedPlanes, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  const Vec3 o{any(random), any(random), any(random)}, s{any(random), any(random), any(random)},
      t{any(random), any(random), any(random)};
  Points p;
  for (auto& x : p) x = o + any(random) * s + any(random) * t;
  expect_antisymmetric(p);
}

TEST(Orient3d, DegenerateSetsAreZero) {
  const Vec3 a{0.1, 0.2, 0.3}, b{1.1, 0.7, 0.9}, c{0.4, 3, 1};
  EXPECT_EQ(orient3d_sign(a, a, b, c), 0);
  EXPECT_EQ(orient3d_sign(a, b, c, b), 0);
  EXPECT_EQ(orient3d_sign(a, a, a, a), 0);
  EXPECT_EQ(orient3d_sign({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.7, 0}), 0);
  EXPECT_EQ(orient3d_sign({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.7, 1e-300}), 1);
  EXPECT_EQ(orient3d_sign({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.7, -1e-300}), -1);
  EXPECT_EQ(orient3d_sign({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
}

}  // namespace
}  // namespace skein::test
