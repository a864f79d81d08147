// The tree finds what a look at all triangles finds.
#include "geometry/surface_tree.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace skein::test {
namespace {

double number() { return *rc::gen::inRange(-1000, 1001) / 1000.0; }
Vec3 point() { return {number(), number(), number()}; }

RC_GTEST_PROP(SurfaceTree, FindsTheNearestTriangle, ()) {
  std::vector<Vec3> points;
  for (int i = 0; i < 60; ++i) points.push_back(point());
  std::vector<SurfaceTree::Triangle> triangles;
  for (int i = 0; i < 50; ++i) {
    const std::int32_t a = *rc::gen::inRange(0, 58);
    triangles.push_back({a, a + 1, a + 2});
  }
  const SurfaceTree tree(points, triangles);
  const Vec3 x = 2 * point();
  const int skip = *rc::gen::inRange(1, 4);
  const auto fits = [&](std::int32_t t) { return t % skip == 0; };
  const auto apart = [&](std::int32_t t) {
    const auto& v = triangles[static_cast<std::size_t>(t)];
    const auto p = [&](std::size_t k) { return points[static_cast<std::size_t>(v[k])]; };
    return nearest_on_triangle(x, p(0), p(1), p(2)).distance2;
  };
  std::int32_t best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t t = 0; t < 50; ++t) {
    if (fits(t) && apart(t) < least) least = apart(t), best = t;
  }
  RC_ASSERT(tree.nearest(points, triangles, x, fits) == best);
}

RC_GTEST_PROP(NearestPoint, IsNoFartherThanAnyOther, ()) {
  const Vec3 a = point(), b = point(), c = point(), x = 2 * point();
  const NearestPoint found = nearest_on_triangle(x, a, b, c);
  const auto& w = found.weight;
  RC_ASSERT(std::min({w[0], w[1], w[2]}) >= 0);
  const Vec3 off = x - (w[0] * a + w[1] * b + w[2] * c);
  RC_ASSERT(std::abs(dot(off, off) - found.distance2) < 1e-12);
  for (int i = 0; i <= 10; ++i) {
    for (int k = 0; i + k <= 10; ++k) {
      const Vec3 to = x - ((10 - i - k) / 10.0 * a + i / 10.0 * b + k / 10.0 * c);
      RC_ASSERT(dot(to, to) >= found.distance2 - 1e-12);
    }
  }
}

TEST(SurfaceTree, FindsNothingWhereNothingIs) {
  const SurfaceTree empty({}, {});
  EXPECT_EQ(empty.nearest({}, {}, {0, 0, 0}, [](std::int32_t) { return true; }), -1);
}

}  // namespace
}  // namespace skein::test
