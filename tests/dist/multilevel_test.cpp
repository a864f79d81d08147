// Multilevel partition and diffusive balance: balance, connected parts, the same answer again, weights respected.
#include "partition/multilevel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "dist/dual_graph.hpp"
#include "dist/partition.hpp"
#include "dist/rebalance.hpp"
#include "partition/graph.hpp"
#include "partition/graph_pieces.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

std::vector<double> ones(const DistMesh& dist) { return std::vector<double>(dist.mesh.tet_slots(), 1.0); }

Vec3 centre(const TetMesh& m, TetId t) {
  Vec3 c;
  for (const VertId v : m.tet2vert[t]) c += 0.25 * m.coords[v];
  return c;
}

TEST(Multilevel, PartsAreBalancedConnectedAndShort) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(12)));
  const auto work = ones(dist);
  for (const int parts : {1, 2, 3, 8, 20}) {
    const auto part = partition(comm, dist, work, parts, PartitionMethod::kMultilevel);
    ASSERT_EQ(part.size(), dist.mesh.tet_slots());
    const auto stats = partition_stats(comm, dist, part, work, parts);
    EXPECT_LE(stats.imbalance, 0.03 + 1.0 * parts / static_cast<double>(dist.global_tets)) << parts;
    EXPECT_EQ(stats.components, parts);
    // Planes of 288 faces are the best cut in 2 and 8, and what the curve gives there; elsewhere the curve is far off.
    if (parts == 2 || parts == 8) {
      EXPECT_LE(static_cast<double>(stats.cut_faces), 1.15 * 288 * (parts == 2 ? 1 : 3));
    } else if (parts > 1) {
      const auto curve = partition_stats(comm, dist, partition(comm, dist, work, parts), work, parts);
      EXPECT_LT(stats.cut_faces, curve.cut_faces) << parts;
    }
  }
}

TEST(Multilevel, ManySmallPartsAreConnected) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(14)));
  const auto work = ones(dist);
  for (const int parts : {150, 256, 400}) {
    const auto stats = partition_stats(comm, dist, multilevel_partition(comm, dist, work, parts), work, parts);
    EXPECT_EQ(stats.components, parts);
    EXPECT_LE(stats.imbalance, 0.03 + 1.0 * parts / static_cast<double>(dist.global_tets)) << parts;
  }
}

TEST(Multilevel, BalancesUnequalWork) {
  const Comm& comm = world();
  const MeshSlice file = slices(comm, cube(12));
  const FieldSlice field = fields(file);
  const DistMesh dist = distribute(comm, file, &field, {.metric_first = true});
  const auto work = predicted_work(dist.mesh);
  const double heaviest = comm.max(work.empty() ? 0.0 : *std::max_element(work.begin(), work.end()));
  const double total = comm.sum(std::accumulate(work.begin(), work.end(), 0.0));
  for (const int parts : {2, 7}) {
    const auto part = multilevel_partition(comm, dist, work, parts);
    const auto stats = partition_stats(comm, dist, part, work, parts);
    EXPECT_LE(stats.imbalance, std::max(0.03, heaviest * parts / total) + 1e-6);
    EXPECT_EQ(stats.components, parts);
  }
}

TEST(Multilevel, SameInputSameParts) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(8)));
  EXPECT_EQ(multilevel_partition(comm, dist, ones(dist), 6), multilevel_partition(comm, dist, ones(dist), 6));
}

bool same_graph(const Graph& a, const Graph& b) {
  const auto same_edge = [](const Edge& x, const Edge& y) { return x.to == y.to && x.weight == y.weight; };
  return a.first == b.first && a.weight == b.weight && std::ranges::equal(a.edge, b.edge, same_edge);
}

/// Threads start to work at 8192 nodes each.
TEST(Multilevel, ThreadsMakeTheSameGraphsAndAsGoodParts) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(16 + 4 * comm.size())));
  const auto work = ones(dist);
  const DistGraph alone = dual_graph(comm, dist, work, {}, 1), shared = dual_graph(comm, dist, work, {}, 3);
  EXPECT_TRUE(same_graph(alone.graph, shared.graph));
  const std::int64_t light = 3 * alone.graph.weight.raw().front();
  const Matching m = match_heavy_edges(alone.graph, light, 0, 3);
  const std::size_t n = alone.graph.nodes();
  ASSERT_GE(n, 2u * 8192);
  EXPECT_LE(m.sets, match_heavy_edges(alone.graph, light).sets + n / 50);
  std::vector<std::vector<NodeId>> members(m.sets);
  for (const NodeId v : IdRange<NodeId>(n)) members.at(idx(m.node2set[v])).push_back(v);
  for (const auto& set : members) {
    ASSERT_TRUE(set.size() == 1 || set.size() == 2);
    const auto row = alone.graph.edges(set.front());
    EXPECT_TRUE(std::ranges::any_of(row, [&](const Edge& e) { return set.size() == 1 || e.to == set.back(); }));
  }
  const std::size_t ghosts = alone.ghosts.remote.size();
  auto coarse = m.node2set;
  for (std::size_t g = 0; g < ghosts; ++g) coarse.push_back(to_id<NodeId>(m.sets + g));
  EXPECT_TRUE(
      same_graph(contract(alone.graph, coarse, m.sets, ghosts, 1), contract(alone.graph, coarse, m.sets, ghosts, 3)));
  for (const int parts : {3, 20}) {
    const MeshCutOptions one{.threads = 1}, three{.threads = 3};
    const auto part = multilevel_partition(comm, dist, work, parts, three);
    EXPECT_EQ(part, multilevel_partition(comm, dist, work, parts, three));
    const auto stats = partition_stats(comm, dist, part, work, parts);
    EXPECT_LE(stats.imbalance, 0.03 + 1e-6);
    EXPECT_EQ(stats.components, parts);
    const auto of_one = partition_stats(comm, dist, multilevel_partition(comm, dist, work, parts, one), work, parts);
    EXPECT_LE(static_cast<double>(stats.cut_faces), 1.1 * static_cast<double>(of_one.cut_faces));
  }
}

TEST(Multilevel, NoWorkCountsAsEqualWork) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(6)));
  const std::vector<double> none(dist.mesh.tet_slots(), 0.0);
  EXPECT_EQ(multilevel_partition(comm, dist, none, 4), multilevel_partition(comm, dist, ones(dist), 4));
}

TEST(Multilevel, MorePartsThanTetrahedra) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(1)));
  const int parts = 50;
  const auto part = multilevel_partition(comm, dist, ones(dist), parts);
  std::vector<std::int64_t> count(static_cast<std::size_t>(parts), 0);
  for (const PartId p : part) {
    ASSERT_GE(num(p), 0);
    ASSERT_LT(num(p), parts);
    ++count[idx(p)];
  }
  comm.reduce(std::span<std::int64_t>(count), Op::kSum);
  EXPECT_LE(*std::max_element(count.begin(), count.end()), 1);
}

TEST(Multilevel, EverythingOnOneRankAndScattered) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(8)));
  const int parts = 5;
  const auto check = [&] {
    const auto work = ones(dist);
    const auto part = multilevel_partition(comm, dist, work, parts);
    const auto stats = partition_stats(comm, dist, part, work, parts);
    EXPECT_LE(stats.imbalance, 0.03 + 1.0 * parts / static_cast<double>(dist.global_tets));
    EXPECT_EQ(stats.components, parts);
  };
  migrate(comm, dist, IdVector<TetId, Rank>(dist.mesh.tet_slots(), to_id<Rank>(comm.size() - 1)));
  check();
  migrate(comm, dist, scatter(comm, dist, 3));
  check();
}

TEST(Multilevel, LoosePiecesGoWhereThereIsRoom) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(8)));
  const DistGraph graph = dual_graph(comm, dist, ones(dist));
  // Two halves, and a ball of each far inside the other.
  const auto at = [&](TetId t) {
    const Vec3 c = centre(dist.mesh, t);
    const auto in_ball = [&](double x) { return norm(c - Vec3{x, 0.5, 0.5}) < 0.2; };
    return (c.x < 0.5) != (in_ball(0.25) || in_ball(0.75)) ? PartId{0} : PartId{1};
  };
  IdVector<NodeId, PartId> start;
  for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) start.push_back(at(t));
  constexpr auto kPlenty = std::numeric_limits<std::int64_t>::max() / 4;
  const auto pieces = [&](const IdVector<NodeId, PartId>& part) {
    return partition_stats(comm, dist, IdVector<TetId, PartId>(part.raw()), ones(dist), 2).components;
  };
  ASSERT_EQ(pieces(start), 4);
  auto part = start;
  EXPECT_EQ(join_pieces(comm, graph, 2, 0, kPlenty, part), 2U);
  EXPECT_EQ(part, start);
  EXPECT_EQ(join_pieces(comm, graph, 2, kPlenty, 1, part), 0U);  // heavier than what counts as loose
  EXPECT_EQ(part, start);
  EXPECT_EQ(join_pieces(comm, graph, 2, kPlenty, kPlenty, part), 0U);
  EXPECT_EQ(pieces(part), 2);
}

TEST(Multilevel, NoCutThroughHeavyFaces) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(8)));
  // Slabs at the middles, where equal parts would like to be cut.
  std::vector<std::int32_t> heavy(4 * dist.mesh.tet_slots(), 1);
  const auto near_middle = [&](FaceId f) {
    for (const VertId v : dist.mesh.verts(f)) {
      if (std::abs(dist.mesh.coords[v].x - 0.5) > 1e-9) return false;
    }
    return true;
  };
  std::int64_t marked = 0;
  for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) {
    for (std::size_t s = 0; s < 4; ++s) {
      if (!near_middle(make_face(t, s)) || centre(dist.mesh, t).x > 0.5) continue;  // marked on one side only
      heavy[idx(make_face(t, s))] = 1000;
      ++marked;
    }
  }
  ASSERT_EQ(comm.sum(marked), 128);
  const auto part = multilevel_partition(comm, dist, ones(dist), 2, {.face_weight = heavy});
  // Both sides of the middle plane, by place, must be in the same part.
  std::vector<std::int64_t> below(16 * 16, -1), above(16 * 16, -1);
  for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) {
    for (std::size_t s = 0; s < 4; ++s) {
      if (!near_middle(make_face(t, s))) continue;
      Vec3 c;
      for (const VertId v : dist.mesh.verts(make_face(t, s))) c += (1.0 / 3) * dist.mesh.coords[v];
      const auto at = static_cast<std::size_t>(c.y * 16) * 16 + static_cast<std::size_t>(c.z * 16);
      (centre(dist.mesh, t).x < 0.5 ? below : above)[at] = num(part[t]);
    }
  }
  comm.reduce(std::span<std::int64_t>(below), Op::kMax);
  comm.reduce(std::span<std::int64_t>(above), Op::kMax);
  EXPECT_EQ(below, above);
  const auto stats = partition_stats(comm, dist, part, ones(dist), 2);
  EXPECT_LE(stats.imbalance, 0.031);
}

/// Moves as rebalance() says; imbalance after it and the share of the work that moved.
struct Balanced {
  double before = 0, after = 0, moved = 0;
};
template <class Work>
Balanced run_rebalance(const Comm& comm, DistMesh& dist, Work work_at) {
  const auto work_now = [&] {
    std::vector<double> work;
    for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) work.push_back(work_at(centre(dist.mesh, t)));
    return work;
  };
  const auto imbalance = [&] {
    const auto work = work_now();
    const double mine = std::accumulate(work.begin(), work.end(), 0.0);
    return comm.max(mine) * comm.size() / comm.sum(mine) - 1;
  };
  Balanced b;
  b.before = imbalance();
  const auto work = work_now();
  const auto dest = rebalance(comm, dist, work);
  EXPECT_EQ(dest, rebalance(comm, dist, work));
  double moved = 0;
  for (const TetId t : IdRange<TetId>(dest.size())) moved += dest[t] != comm.rank() ? work[idx(t)] : 0;
  b.moved = comm.sum(moved) / comm.sum(std::accumulate(work.begin(), work.end(), 0.0));
  migrate(comm, dist, dest);
  b.after = imbalance();
  return b;
}

TEST(Rebalance, NothingMovesWhenBalanced) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(8)));
  EXPECT_EQ(run_rebalance(comm, dist, [](Vec3) { return 1.0; }).moved, 0);
}

TEST(Rebalance, LittleMovesWhenWorkGrowsInOneCorner) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(12)));
  const auto b = run_rebalance(comm, dist, [](Vec3 x) { return x.x < 0.5 && x.y < 0.5 && x.z < 0.5 ? 3.0 : 1.0; });
  EXPECT_LE(b.after, 0.035);
  if (comm.size() > 1) {
    EXPECT_GT(b.before, 0.1);
  }
  // Each rank's surplus must cross at least one interface, and here at most comm.size() - 1.
  EXPECT_LE(b.moved, (comm.size() - 1) * std::max(0.0, b.before));
}

TEST(Rebalance, RanksWithoutTetrahedra) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(8)));
  migrate(comm, dist, IdVector<TetId, Rank>(dist.mesh.tet_slots(), Rank{0}));
  const auto b = run_rebalance(comm, dist, [](Vec3) { return 1.0; });
  EXPECT_LE(b.after, 0.035);
  DistMesh tiny = distribute(comm, slices(comm, cube(1)));
  migrate(comm, tiny, IdVector<TetId, Rank>(tiny.mesh.tet_slots(), to_id<Rank>(comm.size() - 1)));
  EXPECT_LE(run_rebalance(comm, tiny, [](Vec3) { return 1.0; }).after, 1.0);
}

}  // namespace
}  // namespace skein::test
