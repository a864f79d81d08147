// Boxes: joins, containment and distance against what the points say.
#include "base/box.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

namespace skein::test {
namespace {

rc::Gen<Vec3> points() {
  const auto number = rc::gen::map(rc::gen::inRange(-1000, 1000), [](int i) { return i / 8.0; });
  return rc::gen::apply([](double x, double y, double z) { return Vec3{x, y, z}; }, number, number, number);
}

RC_GTEST_PROP(Box, HoldsItsPointsAndNoMore, ()) {
  const auto all = *rc::gen::nonEmpty(rc::gen::container<std::vector<Vec3>>(points()));
  const Box box = bounding_box(all);
  Vec3 low = all[0], high = all[0];
  for (const Vec3 x : all) {
    RC_ASSERT(contains(box, x) && distance2(box, x) == 0);
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  RC_ASSERT(box.low == low && box.high == high);
}

RC_GTEST_PROP(Box, JoinIsTheBoxOfAllPoints, ()) {
  const auto a = *rc::gen::container<std::vector<Vec3>>(points()), b = *rc::gen::container<std::vector<Vec3>>(points());
  auto both = a;
  both.insert(both.end(), b.begin(), b.end());
  const Box got = join(bounding_box(a), bounding_box(b)), want = bounding_box(both);
  RC_ASSERT(got.low == want.low && got.high == want.high);
}

RC_GTEST_PROP(Box, DistanceIsThatToTheNearestPointOfIt, ()) {
  const Box box = join(join(kEmptyBox, *points()), *points());
  const Vec3 x = *points();
  const Vec3 near{std::clamp(x.x, box.low.x, box.high.x), std::clamp(x.y, box.low.y, box.high.y),
                  std::clamp(x.z, box.low.z, box.high.z)};
  RC_ASSERT(std::abs(distance2(box, x) - dot(x - near, x - near)) <= 1e-12);
  RC_ASSERT(contains(box, x) == (distance2(box, x) == 0));
}

TEST(Box, TheEmptyOneHoldsNothing) {
  EXPECT_FALSE(contains(kEmptyBox, {0, 0, 0}));
  const Box box = bounding_box({});
  EXPECT_TRUE(box.low == kEmptyBox.low && box.high == kEmptyBox.high);
}

}  // namespace
}  // namespace skein::test
