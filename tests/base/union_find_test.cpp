// Disjoint sets against labels that are renamed one by one.
#include "base/union_find.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace skein::test {
namespace {

RC_GTEST_PROP(UnionFind, JoinsAsLabelsDo, ()) {
  UnionFind<VertId> sets(3);
  for (int again = 0; again < 2; ++again) {
    const auto n = *rc::gen::inRange(1, 60);
    sets.reset(static_cast<std::size_t>(n));
    std::vector<int> label;
    for (int i = 0; i < n; ++i) label.push_back(i);
    const auto joins = *rc::gen::container<std::vector<std::pair<int, int>>>(
        rc::gen::pair(rc::gen::inRange(0, n), rc::gen::inRange(0, n)));
    for (const auto& [a, b] : joins) {
      const int low = std::min(label[a], label[b]), high = std::max(label[a], label[b]);
      RC_ASSERT(sets.join(VertId{a}, VertId{b}) == (low != high));
      for (int& l : label) l = l == high ? low : l;
    }
    for (int i = 0; i < n; ++i) RC_ASSERT(num(sets.root(VertId{i})) == label[i]);  // the smallest member
  }
}

}  // namespace
}  // namespace skein::test
