// More ranks than tetrahedra: empty ranks take part in everything.
#include <gtest/gtest.h>

#include "dist/interface.hpp"
#include "dist/partition.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

TEST(Tiny, SixTetrahedra) {
  const Comm& comm = world();
  const MeshSlice file = slices(comm, cube(1));
  const FieldSlice field = fields(file);
  DistMesh dist = distribute(comm, file, &field, {.metric_first = true});
  reconcile(comm, dist);
  const Content before = content(comm, to_slices(comm, dist));
  EXPECT_EQ(before.tets, content(comm, file).tets);
  EXPECT_EQ(before.tris, content(comm, file).tris);
  EXPECT_EQ(before.ridges.size(), 12u);
  EXPECT_EQ(before.corners.size(), 8u);
  for (int round = 0; round < 4; ++round) {
    mark_active_band(comm, dist, 1);
    migrate(comm, dist, displace_interface(comm, dist, 1, round));
    reconcile(comm, dist);
    migrate(comm, dist, scatter(comm, dist, static_cast<unsigned>(round)));
    reconcile(comm, dist);
    EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
    const auto work = predicted_work(dist.mesh);
    const auto part = partition(comm, dist, work, comm.size());
    EXPECT_GE(partition_stats(comm, dist, part, work, comm.size()).components, 1);
    migrate(comm, dist, part);
    reconcile(comm, dist);
  }
  renumber_compact(comm, dist);
  reconcile(comm, dist);
  EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
}

TEST(Tiny, NoTetrahedraAtAll) {
  const Comm& comm = world();
  const WholeMesh nothing;
  DistMesh dist = distribute(comm, slices(comm, nothing));
  migrate(comm, dist, Moves{});
  EXPECT_NO_THROW(reconcile(comm, dist));
  EXPECT_EQ(dist.global_tets, 0);
}

TEST(Tiny, LargerMeshOnEightRanks) {
  const Comm& comm = world();
  DistMesh dist = distribute(comm, slices(comm, cube(4, Regions::kTwoTagged)));
  reconcile(comm, dist);
  const Content before = content(comm, to_slices(comm, dist));
  for (unsigned seed = 0; seed < 3; ++seed) {
    migrate(comm, dist, scatter(comm, dist, seed));
    reconcile(comm, dist);
  }
  EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
}

}  // namespace
}  // namespace skein::test
