// Halo: the same bits on every copy, however badly the values are scaled.
#include "comm/halo.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "tests/support/world.hpp"

namespace skein {
namespace {

using test::world;

/// Vertex g (0..n-1) is on rank r when bit r of g+1 is set (below 2^ranks): every set of ranks occurs.
struct Case {
  std::vector<std::int64_t>
      gid;  // of the local vertices; numbered from the highest, so local order is not the global one
  Sharing sharing;
};

bool has(std::int64_t g, int r) { return (((g % ((1 << world().size()) - 1)) + 1) >> r & 1) != 0; }

Case make_case(std::int64_t n) {
  Case c;
  const int self = num(world().rank());
  for (std::int64_t g = n - 1; g >= 0; --g) {
    if (has(g, self)) c.gid.push_back(g);
  }
  for (std::size_t i = c.gid.size(); i-- > 0;) {
    const std::int64_t g = c.gid[i];
    const std::size_t before = c.sharing.rank.size();
    for (int r = 0; r < world().size(); ++r) {
      if (r != self && has(g, r)) c.sharing.rank.push_back(Rank{r});
    }
    if (c.sharing.rank.size() == before) continue;
    c.sharing.vert.push_back(to_id<VertId>(i));
    c.sharing.gid.push_back(GlobalId{g});
    c.sharing.offset.push_back(c.sharing.rank.size());
  }
  return c;
}

// Not inlined: its product must not be fused with a sum.
[[gnu::noinline]] double wild(std::int64_t g, int r, int k) {
  const double scale[] = {1e-16, 1e16, 1, -1e16, 3e-9};
  return scale[(g + 2 * r + k) % 5] * (1 + std::sin(static_cast<double>(g + 17 * r + k)));
}

/// The fold over all ranks that have the vertex, in ascending order, computed here without communication.
template <class F>
double serial(std::int64_t g, int k, F fold) {
  double total = 0;
  bool first = true;
  for (int r = 0; r < world().size(); ++r) {
    if (!has(g, r)) continue;
    total = first ? wild(g, r, k) : fold(total, wild(g, r, k));
    first = false;
  }
  return total;
}

constexpr std::int64_t kVerts = 307;

template <class Call, class F>
void check(int width, Call call, F fold) {
  const Case c = make_case(kVerts);
  const Halo halo(world(), c.sharing);
  std::vector<double> v;
  for (const auto g : c.gid) {
    for (int k = 0; k < width; ++k) v.push_back(wild(g, num(world().rank()), k));
  }
  call(halo, v);
  std::size_t at = 0;
  for (const auto g : c.gid) {
    for (int k = 0; k < width; ++k, ++at)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(v[at]), std::bit_cast<std::uint64_t>(serial(g, k, fold))) << g;
  }
}

TEST(Halo, sums_equal_the_sum_in_rank_order_bit_by_bit) {
  for (const int width : {1, 3, 6}) {
    check(
        width, [&](const Halo& h, std::vector<double>& v) { h.sum(std::span(v), width); },
        [](double a, double b) { return a + b; });
  }
}
TEST(Halo, minimum_and_maximum) {
  check(
      2, [](const Halo& h, std::vector<double>& v) { h.min(std::span(v), 2); },
      [](double a, double b) { return std::min(a, b); });
  check(
      1, [](const Halo& h, std::vector<double>& v) { h.max(std::span(v)); },
      [](double a, double b) { return std::max(a, b); });
}
TEST(Halo, copy_from_owner_gives_the_lowest_ranks_copy) {
  check(
      2, [](const Halo& h, std::vector<double>& v) { h.copy_from_owner(std::span(v), 2); },
      [](double a, double) { return a; });
}

TEST(Halo, integers_count_the_copies) {
  const Case c = make_case(kVerts);
  const Halo halo(world(), c.sharing);
  std::vector<std::int64_t> copies(c.gid.size(), 1);
  halo.sum(std::span(copies));
  std::int64_t owned = static_cast<std::int64_t>(c.gid.size());
  for (std::size_t i = 0; i < c.sharing.size(); ++i) {
    EXPECT_EQ(copies[idx(c.sharing.vert[i])], static_cast<std::int64_t>(c.sharing.others(i).size()) + 1);
    owned -= c.sharing.owned(i, world().rank()) ? 0 : 1;
  }
  EXPECT_EQ(world().sum(owned), kVerts);
}

TEST(Halo, one_number_per_shared_vertex_gives_the_same) {
  const Case c = make_case(kVerts);
  const Halo halo(world(), c.sharing);
  std::vector<double> per_vertex, sums, greatest;
  for (const auto g : c.gid) per_vertex.push_back(wild(g, num(world().rank()), 0));
  for (const VertId v : c.sharing.vert) sums.push_back(per_vertex[idx(v)]);
  greatest = sums;
  auto summed = per_vertex;
  halo.sum(std::span(summed));
  halo.max(std::span(per_vertex));
  halo.sum_shared(std::span(sums));
  halo.max_shared(std::span(greatest));
  for (std::size_t i = 0; i < c.sharing.size(); ++i) {
    EXPECT_EQ(sums[i], summed[idx(c.sharing.vert[i])]);
    EXPECT_EQ(greatest[i], per_vertex[idx(c.sharing.vert[i])]);
  }
}

TEST(Halo, works_with_nothing_shared) {
  const Halo halo(world(), Sharing{});
  std::vector<double> v{1, 2, 3};
  halo.sum(std::span(v));
  EXPECT_EQ(v, (std::vector<double>{1, 2, 3}));
}

TEST(Halo, inconsistent_sharing_is_refused_on_all_ranks) {
  if (world().size() == 1) GTEST_SKIP() << "needs two ranks";
  Case one_sided = make_case(kVerts);
  if (world().is_root()) one_sided.sharing = Sharing{};
  EXPECT_THROW(Halo(world(), one_sided.sharing), AgreedError);
  Case other_ids = make_case(kVerts);
  if (world().is_root() && other_ids.sharing.size() > 0) other_ids.sharing.gid[0] = GlobalId{kVerts + 1};
  EXPECT_THROW(Halo(world(), other_ids.sharing), AgreedError);
}

}  // namespace
}  // namespace skein
