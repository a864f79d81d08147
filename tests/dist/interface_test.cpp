// Displacement of interfaces, the active band, global numbers.
#include "dist/interface.hpp"

#include <gtest/gtest.h>

#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// Collective. Global ids of all shared vertices, ascending.
std::vector<GlobalId> shared_gids(const Comm& comm, const DistMesh& dist) {
  auto all = comm.all_gather(dist.sharing.gid);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

TEST(Interface, DisplacementMakesOldInterfacesInterior) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(8)));
  const Content before = content(comm, to_slices(comm, dist));
  for (int round = 1; round < 4; ++round) {
    const auto old_shared = shared_gids(comm, dist);
    migrate(comm, dist, displace_interface(comm, dist, 1, round));
    reconcile(comm, dist);
    EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
    const auto now = shared_gids(comm, dist);
    std::vector<GlobalId> both;
    std::set_intersection(old_shared.begin(), old_shared.end(), now.begin(), now.end(), std::back_inserter(both));
    if (comm.size() <= 2) {
      EXPECT_TRUE(both.empty()) << both.size();
    }
    if (!old_shared.empty()) {
      EXPECT_LT(both.size(), old_shared.size() / 2);
    }
  }
}

/// Old interface vertices all of whose tetrahedra have labels of one rank only must have become interior.
TEST(Interface, UncontestedVerticesAreNotSharedAfterwards) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(8)));
  const auto dest = displace_interface(comm, dist, 2, 5);
  // Lowest and highest destination at each vertex, over all ranks.
  std::vector<std::int32_t> low(dist.mesh.vert_slots(), comm.size()), high(dist.mesh.vert_slots(), -1);
  for (const TetId t : IdRange<TetId>(dest.size())) {
    for (const VertId v : dist.mesh.tet2vert[t]) {
      low[idx(v)] = std::min(low[idx(v)], num(dest[t]));
      high[idx(v)] = std::max(high[idx(v)], num(dest[t]));
    }
  }
  const Halo halo(comm, dist.sharing);
  halo.min(std::span<std::int32_t>(low));
  halo.max(std::span<std::int32_t>(high));
  std::vector<GlobalId> interior;
  std::size_t contested = 0;
  for (const VertId v : dist.sharing.vert) {
    if (low[idx(v)] == high[idx(v)])
      interior.push_back(dist.vert2gid[v]);
    else
      ++contested;
  }
  interior = comm.all_gather(interior);
  if (comm.size() == 2) {
    EXPECT_EQ(contested, 0u);
  }
  migrate(comm, dist, dest);
  const auto shared = shared_gids(comm, dist);
  for (const GlobalId g : interior) EXPECT_FALSE(std::binary_search(shared.begin(), shared.end(), g));
}

TEST(Interface, LaterRoundsFlowFromHeavyRanksToLightOnes) {
  const Comm& comm = world();
  if (comm.size() == 1) return;
  DistMesh dist = distribute(comm, slices(comm, cube(6)));
  IdVector<TetId, Rank> uneven(dist.mesh.tet_slots(), comm.rank());
  for (const TetId t : IdRange<TetId>(uneven.size() / (2 + idx(comm.rank())))) uneven[t] = Rank{0};
  migrate(comm, dist, uneven);
  for (const int layers : {1, 3}) {
    const auto tets = comm.all_gather(static_cast<std::int64_t>(dist.mesh.tet_slots()));
    const auto [least, most] = std::minmax_element(tets.begin(), tets.end());
    const auto dest = displace_interface(comm, dist, layers, 2);
    std::int64_t to_heaviest = 0, from_lightest = 0, moved = 0;
    for (const Rank r : dest) {
      if (r == comm.rank()) continue;
      ++moved;
      to_heaviest += tets[idx(r)] == *most ? 1 : 0;
      from_lightest += tets[idx(comm.rank())] == *least ? 1 : 0;
    }
    EXPECT_GT(comm.sum(moved), 0);
    ASSERT_LT(*least, *most);
    const auto alone = [&](std::int64_t n) { return std::count(tets.begin(), tets.end(), n) == 1; };
    EXPECT_EQ(alone(*most) ? comm.sum(to_heaviest) : 0, 0);
    EXPECT_EQ(alone(*least) ? comm.sum(from_lightest) : 0, 0);
    migrate(comm, dist, dest);
  }
}

/// Edges from a to b in the cube of n^3 cells: an edge joins cells (i,j,k) that differ by 0 or 1 each, all with the
/// same sign.
long steps(int n, Vec3 a, Vec3 b) {
  double up = 0, down = 0;
  for (const double c : {n * (b.x - a.x), n * (b.y - a.y), n * (b.z - a.z)}) {
    up = std::max(up, c);
    down = std::max(down, -c);
  }
  return std::lround(up + down);
}

TEST(Interface, ActiveBandHasItsWidthOnAllRanks) {
  const Comm& comm = world();
  const int n = 6, layers = 2;
  DistMesh dist = distribute(comm, slices(comm, cube(n)));
  for (VertState& s : dist.mesh.vert_state) s |= kActive | kBesideFrozen;
  mark_active_band(comm, dist, layers);
  std::vector<Vec3> seeds;
  for (const VertId v : dist.sharing.vert) seeds.push_back(dist.mesh.coords[v]);
  seeds = comm.all_gather(seeds);
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    bool near = false;
    for (const Vec3 s : seeds) near = near || steps(n, s, dist.mesh.coords[v]) <= layers;
    EXPECT_EQ(dist.mesh.has(v, kActive), near);
  }
}

TEST(Interface, OnlyPoorVerticesFollowButRoundRetryVertices) {
  const Comm& comm = world();
  const int n = 6;
  DistMesh dist = distribute(comm, slices(comm, cube(n)));
  const auto is_retry = [](Vec3 x) { return x.x == 0 && x.y == 0; };
  const auto is_poor = [](Vec3 x) { return x.z > 0.4; };
  std::vector<Vec3> bad, shared;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const Vec3 x = dist.mesh.coords[v];
    if (is_retry(x)) dist.mesh.vert_state[v] |= kRetry;
    if (is_poor(x)) dist.mesh.vert_state[v] |= kBesideFrozen;
    if (is_retry(x)) bad.push_back(x);
  }
  for (const VertId v : dist.sharing.vert) shared.push_back(dist.mesh.coords[v]);
  bad = comm.all_gather(bad);
  shared = comm.all_gather(shared);
  EXPECT_TRUE(mark_active_band(comm, dist, 1));
  const auto within = [&](const std::vector<Vec3>& seeds, Vec3 x, int layers) {
    return std::any_of(seeds.begin(), seeds.end(), [&](Vec3 s) { return steps(n, s, x) <= layers; });
  };
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const Vec3 x = dist.mesh.coords[v];
    EXPECT_EQ(dist.mesh.has(v, kActive), within(bad, x, 1) || within(shared, x, is_poor(x) ? 1 : 0));
  }
}

TEST(Interface, LeavesWhatHasHigherNumbersAlone) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(6)));
  const GlobalId before{dist.global_verts / 2};
  const auto dest = displace_interface(comm, dist, 0, 1, before);
  IdVector<VertId, char> old(dist.mesh.vert_slots(), 0);
  std::int64_t seeds = 0;
  for (const VertId v : dist.sharing.vert) seeds += old[v] = dist.vert2gid[v] < before ? 1 : 0;
  for (const TetId t : IdRange<TetId>(dest.size())) {
    const auto& v = dist.mesh.tet2vert[t];
    if ((old[v[0]] | old[v[1]] | old[v[2]] | old[v[3]]) == 0) {
      EXPECT_EQ(dest[t], comm.rank());
    }
  }
  EXPECT_EQ(mark_active_band(comm, dist, 0, before), comm.sum(seeds) > 0);
  for (const VertId v : IdRange<VertId>(old.size())) EXPECT_EQ(dist.mesh.has(v, kActive), old[v] != 0);
  for (VertState& s : dist.mesh.vert_state) s &= ~kRetry;  // as the kernel does
  EXPECT_FALSE(mark_active_band(comm, dist, 1, GlobalId{0}));
  for (const VertState s : dist.mesh.vert_state) EXPECT_FALSE(any(s & kActive));
}

TEST(Interface, RetryVerticesBecomeInteriorAndActive) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(8)));
  // One place of the interface, told by the lowest of its copies only.
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  if (dist.sharing.size() > 0) lowest = num(dist.sharing.gid.front());
  const GlobalId retry{comm.min(lowest)};
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) {
    if (dist.sharing.gid[i] == retry && dist.sharing.owned(i, comm.rank()))
      dist.mesh.vert_state[dist.sharing.vert[i]] |= kRetry;
  }
  EXPECT_EQ(mark_active_band(comm, dist, 1, GlobalId{0}), comm.size() > 1);
  for (int round = 1; round < 4; ++round) {
    migrate(comm, dist, displace_interface(comm, dist, 1, round, GlobalId{0}));
    reconcile(comm, dist);
  }
  const auto shared = shared_gids(comm, dist);
  EXPECT_FALSE(std::binary_search(shared.begin(), shared.end(), retry));
  std::int64_t active = 0;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    EXPECT_EQ(dist.mesh.has(v, kRetry), dist.vert2gid[v] == retry);
    active += dist.mesh.has(v, kActive) ? 1 : 0;
  }
  active = comm.sum(active);
  EXPECT_EQ(active > 0, comm.size() > 1);
  EXPECT_LT(active, dist.global_verts / 4);
}

TEST(Interface, NewNumbersAreDistinctAndCompactOnesAreDense) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(4)));
  const auto verts = dist.global_verts;
  // Vertices of this rank alone forget their numbers, as if they were new.
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    if (!dist.mesh.has(v, kFrozen)) dist.vert2gid[v] = kNoGlobal;
  }
  EXPECT_NO_THROW(reconcile(comm, dist));
  number_new_vertices(comm, dist);
  reconcile(comm, dist);
  EXPECT_EQ(dist.global_verts, verts);
  renumber_compact(comm, dist);
  reconcile(comm, dist);
  auto all = comm.all_gather(dist.vert2gid.raw());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  ASSERT_EQ(std::ssize(all), verts);
  EXPECT_EQ(all.front(), GlobalId{0});
  EXPECT_EQ(all.back(), GlobalId{verts - 1});
}

}  // namespace
}  // namespace skein::test
