// distribute(): nothing is lost, features and corners are found, whatever the number of ranks.
#include <gtest/gtest.h>

#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// Straight edges of the unit cube's twelve sides have two coordinates that are 0 or 1.
int on_sides(const std::vector<double>& x, std::size_t at) {
  int n = 0;
  for (std::size_t k = 0; k < 3; ++k) n += x[at + k] == 0 || x[at + k] == 1 ? 1 : 0;
  return n;
}

TEST(Distribute, KeepsEverythingOfACube) {
  const Comm& comm = world();
  const WholeMesh whole = cube(4);
  const MeshSlice file = slices(comm, whole);
  DistributeReport report;
  const DistMesh dist = distribute(comm, file, nullptr, {}, &report);
  EXPECT_NO_THROW(reconcile(comm, dist));
  EXPECT_EQ(check(dist.mesh), "");
  const Content before = content(comm, file), after = content(comm, to_slices(comm, dist));
  EXPECT_EQ(before.verts, after.verts);
  EXPECT_EQ(before.tets, after.tets);
  EXPECT_EQ(before.tris, after.tris);
  EXPECT_EQ(after.ridges.size(), 48u);
  for (const auto& e : after.ridges) EXPECT_TRUE(on_sides(e, 0) >= 2 && on_sides(e, 3) >= 2);
  EXPECT_EQ(after.corners.size(), 8u);
  for (const auto& c : after.corners) EXPECT_EQ(on_sides(c, 0), 3);
  EXPECT_EQ(report.untagged_hull_faces, 0);
  EXPECT_EQ(report.unused_verts, 0);
  EXPECT_EQ(report.found_ridges, 48);
  EXPECT_EQ(report.turned_tets + report.double_tets + report.double_triangles + report.double_edges, 0);
  EXPECT_EQ(dist.global_tets, 6 * 64);
  EXPECT_EQ(dist.global_verts, 125);
}

TEST(Distribute, MeasuresAreConserved) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(4, Regions::kTwoTagged)));
  const Measure m = measure(comm, dist);
  EXPECT_NEAR(m.volume, 1, 1e-12);
  ASSERT_EQ(m.area.size(), 7u);
  for (const auto& [ref, area] : m.area) EXPECT_NEAR(area, 1, 1e-12) << ref;
  EXPECT_NEAR(m.feature_length, 16, 1e-12);  // 12 sides, 4 where the inner faces meet the hull
}

TEST(Distribute, OutputIsAsGoodAnInput) {
  const Comm& comm = world();
  const DistMesh first = distribute(comm, slices(comm, cube(4, Regions::kTwoTagged)));
  const MeshSlice out = to_slices(comm, first);
  const DistMesh second = distribute(comm, out);
  reconcile(comm, second);
  EXPECT_EQ(content(comm, out), content(comm, to_slices(comm, second)));
}

TEST(Distribute, BareRegionFacesGetAPatch) {
  const Comm& comm = world();
  DistributeReport report;
  const DistMesh dist = distribute(comm, slices(comm, cube(4, Regions::kTwo)), nullptr, {}, &report);
  reconcile(comm, dist);
  EXPECT_EQ(check(dist.mesh), "");
  EXPECT_EQ(report.untagged_region_faces, 32);
  const Measure m = measure(comm, dist);
  ASSERT_EQ(m.area.count(7), 1u);
  EXPECT_NEAR(m.area.at(7), 1, 1e-12);
}

TEST(Distribute, BareHullGetsAPatch) {
  const Comm& comm = world();
  WholeMesh whole = cube(3);
  std::vector<std::array<std::int64_t, 3>> tris;
  std::vector<std::int32_t> refs;
  for (std::size_t i = 0; i < whole.tris.size(); ++i) {
    if (whole.tri_ref[i] == 2) continue;
    tris.push_back(whole.tris[i]);
    refs.push_back(whole.tri_ref[i]);
  }
  whole.tris = tris;
  whole.tri_ref = refs;
  DistributeReport report;
  const DistMesh dist = distribute(comm, slices(comm, whole), nullptr, {}, &report);
  reconcile(comm, dist);
  EXPECT_EQ(report.untagged_hull_faces, 18);
  const Measure m = measure(comm, dist);
  ASSERT_EQ(m.area.count(7), 1u);
  EXPECT_NEAR(m.area.at(7), 1, 1e-12);
  EXPECT_EQ(content(comm, to_slices(comm, dist)).ridges.size(), 36u);

  whole.tris.clear();
  whole.tri_ref.clear();
  const DistMesh bare = distribute(comm, slices(comm, whole));
  EXPECT_NEAR(measure(comm, bare).area.at(1), 6, 1e-12);
  EXPECT_EQ(content(comm, to_slices(comm, bare)).ridges.size(), 36u) << "by their angle alone";
}

TEST(Distribute, EdgesOfTheFileSurvive) {
  const Comm& comm = world();
  WholeMesh whole = cube(4);
  // A line in the middle of the side z = 0, one edge of which is a ridge; an edge in the volume; one that is no edge.
  whole.edges = {{10, 11}, {11, 12}, {12, 13}, {31, 56}, {0, 124}};
  whole.edge_ref = {5, 5, 6, 9, 11};
  whole.ridges = {1};
  whole.corners = {62};
  whole.required_verts = {63};
  whole.required_tris = {0, 7};
  DistributeReport report;
  const MeshSlice file = slices(comm, whole);
  const DistMesh dist = distribute(comm, file, nullptr, {}, &report);
  reconcile(comm, dist);
  const Content before = content(comm, file), after = content(comm, to_slices(comm, dist));
  EXPECT_EQ(report.lost_edges, 1);
  EXPECT_EQ(after.edges.size(), 48u + 4u);
  EXPECT_EQ(after.ridges.size(), 48u + 1u);
  for (const auto& e : before.edges) {
    if (e.back() != 11) {
      EXPECT_TRUE(std::binary_search(after.edges.begin(), after.edges.end(), e)) << e.back();
    }
  }
  EXPECT_TRUE(std::binary_search(after.corners.begin(), after.corners.end(), before.corners[0]));
  EXPECT_EQ(after.required_verts, before.required_verts);
  EXPECT_EQ(after.required_tris, before.required_tris);
}

TEST(Distribute, FlagsAndDataAreTheSameOnAllCopies) {
  const Comm& comm = world();
  const MeshSlice file = slices(comm, cube(4));
  const FieldSlice field = fields(file);
  DistributeOptions options;
  options.metric_first = true;
  options.work_from_metric = true;
  const DistMesh dist = distribute(comm, file, &field, options);
  reconcile(comm, dist);
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const Vec3 x = dist.mesh.coords[v];
    EXPECT_EQ(dist.mesh.log_metric[v].xx, 2 + 6 * x.x);
    EXPECT_EQ(dist.mesh.fields.at(v)[0], x.x + 2 * x.y + 4 * x.z);
    EXPECT_EQ(dist.mesh.vert_ref[v], num(dist.vert2gid[v]) % 5);
    const int sides = on_sides({x.x, x.y, x.z}, 0);
    EXPECT_EQ(dist.mesh.has(v, kSurface), sides >= 1);
    EXPECT_EQ(dist.mesh.has(v, kRidge), sides >= 2);
    EXPECT_EQ(dist.mesh.has(v, kCorner), sides >= 3);
    EXPECT_FALSE(dist.mesh.has(v, kActive));
  }
  const FieldSlice out = to_field_slices(comm, dist, {FieldKind::kScalar});
  const MeshSlice written = to_slices(comm, dist);
  ASSERT_EQ(out.values.size(), written.coords.size());
  EXPECT_EQ(out.first, written.first_vert);
  for (std::size_t v = 0; v < out.values.size(); ++v) {
    const Vec3 x = written.coords[v];
    EXPECT_EQ(out.values[v], x.x + 2 * x.y + 4 * x.z);
  }
}

TEST(Distribute, AllInvertedIsTurnedAndUnusedVerticesAreDropped) {
  const Comm& comm = world();
  WholeMesh whole = cube(2);
  for (auto& t : whole.tets) std::swap(t[1], t[3]);
  whole.coords.push_back({9, 9, 9});
  DistributeReport report;
  const DistMesh dist = distribute(comm, slices(comm, whole), nullptr, {}, &report);
  reconcile(comm, dist);
  EXPECT_EQ(check(dist.mesh), "");
  EXPECT_EQ(report.turned_tets, 48);
  EXPECT_EQ(report.unused_verts, 1);
  EXPECT_EQ(dist.global_verts, 27);
  EXPECT_NEAR(measure(comm, dist).volume, 1, 1e-12);
}

/// Two cubes, the second moved by `shift`; vertices at the same place are one.
WholeMesh two_cubes(int n, Vec3 shift) {
  WholeMesh w = cube(n);
  const WholeMesh b = cube(n);
  std::vector<std::int64_t> number;
  for (const Vec3 x : b.coords) {
    const Vec3 y = x + shift;
    auto it = std::find(w.coords.begin(), w.coords.end(), y);
    if (it == w.coords.end()) it = w.coords.insert(w.coords.end(), y);
    number.push_back(it - w.coords.begin());
  }
  for (auto t : b.tets) {
    for (auto& v : t) v = number[v];
    w.tets.push_back(t);
    w.tet_ref.push_back(1);
  }
  for (std::size_t i = 0; i < b.tris.size(); ++i) {
    auto t = b.tris[i];
    for (auto& v : t) v = number[v];
    w.tris.push_back(t);
    w.tri_ref.push_back(b.tri_ref[i]);
  }
  return w;
}

TEST(Distribute, PinchedDomainsShareTheirVertices) {
  const Comm& comm = world();
  for (const Vec3 shift : {Vec3{1, 1, 1}, Vec3{1, 1, 0}, Vec3{1, 0.5, 1}}) {
    const MeshSlice file = slices(comm, two_cubes(2, shift));
    DistMesh dist = distribute(comm, file);
    reconcile(comm, dist);
    EXPECT_EQ(dist.global_verts, file.total_verts);
    const Content before = content(comm, to_slices(comm, dist));
    for (unsigned seed = 1; seed < 3; ++seed) {
      migrate(comm, dist, scatter(comm, dist, seed));
      reconcile(comm, dist);
    }
    EXPECT_EQ(before, content(comm, to_slices(comm, dist)));
  }
}

TEST(Distribute, SurfacesThatTouchInAVertexMakeACorner) {
  const Comm& comm = world();
  WholeMesh whole = two_cubes(2, {1, 1, 1});
  for (auto& r : whole.tri_ref) r = 1;
  DistributeOptions options;
  options.ridge_angle = 180;  // no ridge anywhere: only the pinched vertex is left
  const DistMesh dist = distribute(comm, slices(comm, whole), nullptr, options);
  reconcile(comm, dist);
  const Content found = content(comm, to_slices(comm, dist));
  EXPECT_EQ(found.ridges.size(), 0u);
  ASSERT_EQ(found.corners.size(), 1u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(found.corners[0][k], 1);
}

}  // namespace
}  // namespace skein::test
