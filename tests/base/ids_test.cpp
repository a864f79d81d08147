// Heavy assertions: an index that is no place of its array ends the program, and the line tells what does not hold.
#undef SKEIN_ASSERT_LEVEL
#define SKEIN_ASSERT_LEVEL 3  // whatever the build has: no other file of this program knows the array below
#include "base/ids.hpp"

#include <gtest/gtest.h>

namespace skein::test {
namespace {

enum class Id : std::int32_t {};

TEST(IdVectorDeathTest, ChecksItsIndices) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  IdVector<Id, int> v(3, 7);
  const IdVector<Id, int>& same = v;
  EXPECT_EQ(v[Id{2}] + same[Id{0}], 14);
  EXPECT_DEATH(v[Id{3}] = 1, "assertion failed: idx\\(i\\) < data_.size\\(\\)");
  EXPECT_DEATH(v[Id{-1}] = 1, "assertion failed");
  EXPECT_DEATH((void)same[Id{3}], "assertion failed");
}

}  // namespace
}  // namespace skein::test
