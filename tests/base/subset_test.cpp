// Numbered sets, and vectors that threads grow.
#include "base/subset.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

#include "base/parallel.hpp"

namespace skein::test {
namespace {

RC_GTEST_PROP(Subset, NumbersItsMembersInOrder, ()) {
  const auto n = *rc::gen::inRange<std::size_t>(1, 400);
  const auto chosen = *rc::gen::container<std::set<std::int32_t>>(rc::gen::inRange(0, static_cast<std::int32_t>(n)));
  Subset<VertId> set(n);
  for (const std::int32_t i : chosen) set.insert(VertId{i});
  if (!chosen.empty()) set.insert(VertId{*chosen.begin()});  // twice is once
  set.number();
  RC_ASSERT(set.size() == chosen.size());
  std::vector<VertId> members;
  for (const std::int32_t i : chosen) members.push_back(VertId{i});
  RC_ASSERT(set.members() == members);
  for (std::size_t k = 0; k < members.size(); ++k) RC_ASSERT(set.place(members[k]) == k);
  for (const VertId v : IdRange<VertId>(n)) RC_ASSERT(set.has(v) == (chosen.count(num(v)) != 0));
}

RC_GTEST_PROP(GrowInParallel, KeepsWhatIsThereAndClearsTheRest, ()) {
  const auto before = *rc::gen::inRange<std::size_t>(0, 20'000), after = *rc::gen::inRange<std::size_t>(0, 40'000);
  const int threads = *rc::gen::inRange(1, 9);
  std::vector<std::int32_t> a(before, 1);
  std::vector<std::array<double, 3>> b(before, {1, 1, 1});
  std::vector<char> c(before, 1);
  grow_in_parallel(threads, std::tie(a, b, c), after);
  const std::size_t n = std::max(before, after);  // it never takes any away
  RC_ASSERT(a.size() == n && b.size() == n && c.size() == n);
  for (std::size_t i = 0; i < n; ++i) {
    const int want = i < before ? 1 : 0;
    RC_ASSERT(a[i] == want && b[i][0] == want && b[i][2] == want && c[i] == want);
  }
}

}  // namespace
}  // namespace skein::test
