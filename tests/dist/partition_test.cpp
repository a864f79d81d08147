// Partition by the Hilbert curve: balance, order, statistics.
#include "dist/partition.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "dist/rendezvous.hpp"
#include "partition/hilbert.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

TEST(GidMap, GivesTheSameNumbersWithAPlaceForEachIdAndWithout) {
  GidMap hashed(10), direct(10, 40), too_sparse(10, 41);
  for (std::int64_t i = 0; i < 100; ++i) {
    const GlobalId g{i * i * 7 % 40};
    const VertId v = hashed.insert(g);
    EXPECT_EQ(direct.insert(g), v);
    EXPECT_EQ(too_sparse.insert(g), v);
  }
  for (std::int64_t i = 0; i < 40; ++i) {
    EXPECT_EQ(direct.find(GlobalId{i}), hashed.find(GlobalId{i}));
    EXPECT_EQ(too_sparse.find(GlobalId{i}), hashed.find(GlobalId{i}));
  }
  EXPECT_EQ(direct.gids(), hashed.gids());
  EXPECT_LT(direct.size(), 40U);  // some were never there
}

TEST(CutKeys, PartsAreInOrderAndBalanced) {
  const Comm& comm = world();
  std::mt19937_64 random(7 + static_cast<unsigned>(num(comm.rank())));
  std::vector<std::uint64_t> keys(2000 + 500 * static_cast<std::size_t>(num(comm.rank())));
  std::vector<double> work(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i] = random() >> 1;
    if (i % 3 == 0) keys[i] >>= 40;  // crowded at the low end
    work[i] = 1 + static_cast<double>(random() % 10);
  }
  const double total = comm.sum(std::accumulate(work.begin(), work.end(), 0.0));
  for (const int parts : {1, 2, 3, 7, 64}) {
    const auto part = cut_keys(comm, keys, work, parts);
    std::vector<double> sum(static_cast<std::size_t>(parts), 0);
    std::vector<std::uint64_t> low(sum.size(), ~0ULL), high(sum.size(), 0);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const std::size_t p = idx(part[i]);
      ASSERT_LT(p, sum.size());
      sum[p] += work[i];
      low[p] = std::min(low[p], keys[i]);
      high[p] = std::max(high[p], keys[i]);
    }
    comm.reduce(std::span<double>(sum), Op::kSum);
    comm.reduce(std::span<std::uint64_t>(low), Op::kMin);
    comm.reduce(std::span<std::uint64_t>(high), Op::kMax);
    for (std::size_t p = 0; p < sum.size(); ++p) {
      EXPECT_NEAR(sum[p], total / parts, 10.001) << "at most one item beyond";
      if (p > 0) {
        EXPECT_GT(low[p], high[p - 1]);
      }
    }
  }
}

TEST(CutKeys, NothingAndEqualKeys) {
  const Comm& comm = world();
  EXPECT_TRUE(cut_keys(comm, {}, {}, 5).empty());
  const std::vector<std::uint64_t> keys(10, 42);
  const std::vector<double> work(10, 1.0);
  const auto part = cut_keys(comm, keys, work, 3);
  for (const PartId p : part) EXPECT_EQ(p, part[0]);
}

TEST(Partition, BalancesPredictedWork) {
  const Comm& comm = world();
  const MeshSlice file = slices(comm, cube(8));
  const FieldSlice field = fields(file);
  const DistMesh dist = distribute(comm, file, &field, {.metric_first = true});
  const auto work = predicted_work(dist.mesh);
  const int parts = 5;
  double largest = 0;
  for (const double w : work) largest = std::max(largest, w);
  const double mean = comm.sum(std::accumulate(work.begin(), work.end(), 0.0)) / parts;
  for (const auto method : {PartitionMethod::kHilbert, PartitionMethod::kMultilevel}) {
    const bool curve = method == PartitionMethod::kHilbert;
    const auto part = partition(comm, dist, work, parts, method);
    const auto stats = partition_stats(comm, dist, part, work, parts);
    EXPECT_LE(stats.imbalance, (curve ? 0 : 0.03) + comm.max(largest) / mean + 1e-9);
    EXPECT_GE(stats.components, parts);
    EXPECT_LE(stats.components, (curve ? 4 : 2) * parts);
    EXPECT_GT(stats.cut_faces, 0);
  }
}

/// A cube of 384 tetrahedra that asks for edges of length h.
DistMesh wanting(const Comm& comm, double h) {
  const MeshSlice file = slices(comm, cube(4));
  FieldSlice field = fields(file);
  for (std::size_t v = 0; v < file.coords.size(); ++v) {
    for (const std::size_t c : {0u, 2u, 5u}) field.values[v * 7 + c] = std::log(1 / (h * h));
  }
  return distribute(comm, file, &field, {.metric_first = true});
}
double sum(const Comm& comm, const std::vector<double>& v) {
  return comm.sum(std::accumulate(v.begin(), v.end(), 0.0));
}

TEST(Partition, PredictedElementsAreTheMetricVolume) {
  const Comm& comm = world();
  EXPECT_NEAR(sum(comm, predicted_elements(wanting(comm, 0.1).mesh)), 10 * 1000, 1e-6);
  // exp(l) with l linear from 2 to 8 along x: sizes that fall with x, fourfold in a cell.
  const MeshSlice file = slices(comm, cube(4));
  const FieldSlice field = fields(file);
  const double exact = 10 * (std::exp(12.0) - std::exp(3.0)) / 9;  // integral of exp(1.5 (2 + 6 x))
  EXPECT_NEAR(sum(comm, predicted_elements(distribute(comm, file, &field, {.metric_first = true}).mesh)), exact,
              0.03 * exact);
  for (const double e : predicted_elements(distribute(comm, file).mesh)) EXPECT_EQ(e, 1);
}

TEST(Partition, PredictedWorkIsLeastWhereNothingChanges) {
  const Comm& comm = world();
  const double same = std::cbrt(10.0 / 384);  // about one tetrahedron for each
  const double stays = sum(comm, predicted_work(wanting(comm, same).mesh));
  EXPECT_GT(stays, 0);
  EXPECT_GT(sum(comm, predicted_work(wanting(comm, same / 1.5).mesh)), 2 * stays);
  EXPECT_GT(sum(comm, predicted_work(wanting(comm, same * 1.5).mesh)), 2 * stays);
  EXPECT_NEAR(sum(comm, predicted_work(wanting(comm, same / 10).mesh)), 1000 * 384, 0.01 * 1000 * 384);
  for (const double w : predicted_work(distribute(comm, slices(comm, cube(4))).mesh)) EXPECT_EQ(w, 1);
}

TEST(Partition, StatisticsDoNotDependOnWhereTheTetrahedraAre) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(4)));
  // Part by place: slabs in z with parity in x, which makes more pieces than parts.
  const auto by_place = [&] {
    IdVector<TetId, PartId> part(dist.mesh.tet_slots());
    for (const TetId t : IdRange<TetId>(part.size())) {
      Vec3 c;
      for (const VertId v : dist.mesh.tet2vert[t]) c += 0.25 * dist.mesh.coords[v];
      part[t] = PartId{static_cast<int>(4 * c.z) % 2};
    }
    return part;
  };
  for (unsigned seed = 0; seed < 4; ++seed) {
    const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
    const auto stats = partition_stats(comm, dist, by_place(), work, 2);
    EXPECT_EQ(stats.components, 4);  // slabs of one cell's height
    EXPECT_EQ(stats.cut_faces, 3 * 32);
    EXPECT_NEAR(stats.imbalance, 0, 1e-12);
    migrate(comm, dist, scatter(comm, dist, seed));
  }
}

}  // namespace
}  // namespace skein::test
