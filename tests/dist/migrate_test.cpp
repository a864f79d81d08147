// migrate(): any tetrahedra to any ranks, and nothing changes but where they are.
#include <gtest/gtest.h>

#include "dist/interface.hpp"
#include "dist/sharing.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

DistMesh make(const Comm& comm) {
  WholeMesh whole = cube(4, Regions::kTwoTagged);
  whole.edges = {{10, 11}, {11, 12}, {31, 56}};
  whole.edge_ref = {5, 5, 9};
  whole.corners = {62};
  whole.required_verts = {63};
  whole.required_tris = {0, 7};
  const MeshSlice file = slices(comm, whole);
  const FieldSlice field = fields(file);
  DistributeOptions options;
  options.metric_first = true;
  return distribute(comm, file, &field, options);
}

void expect_data_at_place(const DistMesh& dist) {
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const Vec3 x = dist.mesh.coords[v];
    EXPECT_EQ(dist.mesh.fields.at(v)[0], x.x + 2 * x.y + 4 * x.z);
  }
}

TEST(Migrate, RandomTripsKeepEverything) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  const Content before = content(comm, to_slices(comm, dist));
  for (unsigned seed = 1; seed < 6; ++seed) {
    migrate(comm, dist, scatter(comm, dist, seed));
    ASSERT_NO_THROW(reconcile(comm, dist));
    EXPECT_EQ(check(dist.mesh), "");
    EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
    expect_data_at_place(dist);
  }
}

TEST(Migrate, FewTetrahedraMove) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  const Content before = content(comm, to_slices(comm, dist));
  for (unsigned seed = 1; seed < 6; ++seed) {
    IdVector<TetId, Rank> dest(dist.mesh.tet_slots(), comm.rank());
    const auto any = scatter(comm, dist, seed);
    for (std::size_t t = 0; t < dest.size(); t += 7) dest.raw()[t] = any.raw()[t];
    migrate(comm, dist, dest);
    reconcile(comm, dist);
    EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
  }
}

TEST(Migrate, AllToOneRankAndAway) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  const Content before = content(comm, to_slices(comm, dist));
  for (int r = 0; r < comm.size(); ++r) {
    migrate(comm, dist, IdVector<TetId, Rank>(dist.mesh.tet_slots(), Rank{r}));
    reconcile(comm, dist);
    EXPECT_EQ(static_cast<std::int64_t>(dist.mesh.tet_slots()), comm.rank() == Rank{r} ? dist.global_tets : 0);
    EXPECT_EQ(dist.sharing.size(), 0u);
    EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
  }
}

TEST(Migrate, StayingChangesNothing) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  const DistMesh before = dist;
  migrate(comm, dist, IdVector<TetId, Rank>(dist.mesh.tet_slots(), comm.rank()));
  EXPECT_EQ(before.mesh.tet2vert, dist.mesh.tet2vert);
  EXPECT_EQ(before.mesh.tet2face, dist.mesh.tet2face);
  EXPECT_EQ(before.mesh.face_tag, dist.mesh.face_tag);
  EXPECT_EQ(before.mesh.coords, dist.mesh.coords);
  EXPECT_EQ(before.mesh.vert_class, dist.mesh.vert_class);
  EXPECT_EQ(before.mesh.vert_state, dist.mesh.vert_state);
  EXPECT_EQ(before.vert2gid, dist.vert2gid);
  EXPECT_EQ(before.sharing.rank, dist.sharing.rank);
}

TEST(Migrate, ActiveMarksTravelAndFrozenFollowsTheInterface) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  const auto active = [](Vec3 x) { return x.y < 0.4; };
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    if (active(dist.mesh.coords[v])) dist.mesh.vert_state[v] |= kActive;
  }
  migrate(comm, dist, scatter(comm, dist, 4));
  IdVector<VertId, char> shared(dist.mesh.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) shared[v] = 1;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    EXPECT_EQ(dist.mesh.has(v, kActive), active(dist.mesh.coords[v]));
    EXPECT_EQ(dist.mesh.has(v, kFrozen), shared[v] != 0);
  }
}

TEST(Migrate, WorksAfterCompaction) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  const Content before = content(comm, to_slices(comm, dist));
  migrate(comm, dist, scatter(comm, dist, 8));
  compact(dist);
  reconcile(comm, dist);
  expect_data_at_place(dist);
  migrate(comm, dist, scatter(comm, dist, 9));
  reconcile(comm, dist);
  EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
}

TEST(Migrate, SameInputGivesTheSameBytes) {
  const Comm& comm = world();
  const auto run = [&] {
    DistMesh dist = make(comm);
    migrate(comm, dist, scatter(comm, dist, 3));
    migrate(comm, dist, displace_interface(comm, dist, 1, 2));
    return dist;
  };
  const DistMesh a = run(), b = run();
  EXPECT_EQ(a.mesh.tet2vert, b.mesh.tet2vert);
  EXPECT_EQ(a.mesh.tet2face, b.mesh.tet2face);
  EXPECT_EQ(a.mesh.coords, b.mesh.coords);
  EXPECT_EQ(a.mesh.log_metric, b.mesh.log_metric);
  EXPECT_EQ(a.mesh.fields.values, b.mesh.fields.values);
  EXPECT_EQ(a.vert2gid, b.vert2gid);
  EXPECT_EQ(a.sharing.rank, b.sharing.rank);
}

TEST(Migrate, RefusesARankThatIsNotThere) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  IdVector<TetId, Rank> dest(dist.mesh.tet_slots(), comm.rank());
  if (comm.is_root()) dest[TetId{0}] = Rank{comm.size()};
  EXPECT_THROW(migrate(comm, dist, dest), Error);
}

}  // namespace
}  // namespace skein::test
