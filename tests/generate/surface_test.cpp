// Check and repair of surfaces: volume, orientation, voids, and the error lines.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "generate/components.hpp"
#include "generate/surface_check.hpp"
#include "tests/generate/expect_error.hpp"
#include "tests/support/surfaces.hpp"

namespace skein {
namespace {

using test::expect_error;

double signed_volume(const MeshSlice& m) {
  double sum = 0;
  for (const auto& t : m.triangles.verts) {
    sum += dot(m.coords[idx(t[0])], cross(m.coords[idx(t[1])], m.coords[idx(t[2])])) / 6;
  }
  return sum;
}

TEST(CheckSurface, OrientsMixedTriangles) {
  for (const MeshSlice& m : {test::cube_surface(4), test::l_shape(4), test::hollow_cube(6), test::sphere(3)}) {
    const double volume = signed_volume(m);
    const ClosedSurface s = check_surface(test::mixed_up(m));
    EXPECT_NEAR(s.volume, volume, 1e-12);
    EXPECT_NEAR(signed_volume(s.mesh), volume, 1e-12);
    EXPECT_EQ(s.turned_triangles, (m.triangles.total + 2) / 3);
    EXPECT_EQ(s.mesh.triangles.ref, m.triangles.ref);
    EXPECT_EQ(check_surface(m).turned_triangles, 0);
  }
}

TEST(CheckSurface, FindsVoidsAndIslands) {
  const MeshSlice m = test::both(test::both(test::both(test::sphere(2, 8), test::sphere(2, 4)), test::sphere(2, 2)),
                                 test::sphere(1, 1, {6, 0, 0}));
  const ClosedSurface s = check_surface(m);
  EXPECT_EQ(s.shells, 4);
  ASSERT_EQ(s.voids.size(), 2U);  // between the second and third sphere, and in the fourth
  EXPECT_LT(norm(s.voids[0]), 4);
  EXPECT_GT(norm(s.voids[0]), 2 * 0.9);
  EXPECT_LT(norm(s.voids[1] - Vec3{6, 0, 0}), 1);
  const double ball = signed_volume(test::sphere(2)), small = signed_volume(test::sphere(1));
  EXPECT_NEAR(s.volume, (512 - 64 + 8) * ball - small, 1e-9);
}

TEST(CheckSurface, FindsAPointInAThinVoid) {
  MeshSlice plate = test::cube_surface(6);
  for (Vec3& x : plate.coords) x = {0.2 + 0.6 * x.x, 0.2 + 0.6 * x.y, 0.5 + 1e-5 * x.z};
  const ClosedSurface s = check_surface(test::both(test::cube_surface(3), plate));
  ASSERT_EQ(s.voids.size(), 1U);
  EXPECT_GT(s.voids[0].z, 0.5);
  EXPECT_LT(s.voids[0].z, 0.5 + 1e-5);
}

TEST(CheckSurface, TakesBodiesSideBySide) {
  const ClosedSurface s = check_surface(test::both(test::sphere(2), test::sphere(2, 1, {5, 0, 0})));
  EXPECT_EQ(s.shells, 2);
  EXPECT_TRUE(s.voids.empty());
}

TEST(CheckSurface, MergesTwinsAndDropsUnusedVertices) {
  const MeshSlice m = test::cube_surface(3);
  MeshSlice loose;  // every triangle with corners of its own, as STL files have them
  test::add_vertex(loose, {9, 9, 9});
  for (std::size_t t = 0; t < m.triangles.verts.size(); ++t) {
    std::array<GlobalId, 3> v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = test::add_vertex(loose, m.coords[idx(m.triangles.verts[t][k])]);
    test::add_triangle(loose, v[0], v[1], v[2], m.triangles.ref[t]);
  }
  loose.edges = {2, 0, {{GlobalId{1}, GlobalId{2}}, {GlobalId{0}, GlobalId{1}}}, {5, 6}};
  loose.ridges = {2, 0, {GlobalId{0}, GlobalId{1}}};
  loose.corners = {2, 0, {GlobalId{0}, GlobalId{3}}};
  const ClosedSurface s = check_surface(loose);
  EXPECT_EQ(s.mesh.total_verts, m.total_verts);
  EXPECT_EQ(s.mesh.coords.size(), s.mesh.vert_ref.size());
  EXPECT_EQ(s.unused_verts, 1);
  EXPECT_EQ(s.merged_verts, loose.total_verts - 1 - m.total_verts);
  EXPECT_NEAR(s.volume, 1, 1e-12);
  ASSERT_EQ(s.mesh.edges.total, 1);  // the other edge had the dropped vertex
  EXPECT_EQ(s.mesh.edges.ref, std::vector<std::int32_t>{5});
  EXPECT_EQ(s.mesh.coords[idx(s.mesh.edges.verts[0][0])], loose.coords[1]);
  EXPECT_EQ(s.mesh.coords[idx(s.mesh.edges.verts[0][1])], loose.coords[2]);
  EXPECT_EQ(s.mesh.ridges.verts, std::vector<GlobalId>{GlobalId{0}});
  ASSERT_EQ(s.mesh.corners.verts.size(), 1U);
  EXPECT_EQ(s.mesh.coords[idx(s.mesh.corners.verts[0])], loose.coords[3]);
}

TEST(CheckSurface, RefusesWithNumbers) {
  const auto refused = [](MeshSlice m, std::initializer_list<std::string> words) {
    m.path = "body.mesh";
    expect_error([&] { check_surface(std::move(m)); }, ExitCode::kInvalidMesh, words);
  };
  refused(MeshSlice{}, {"body.mesh", "no triangles"});
  MeshSlice m = test::sphere(1);
  m.triangles.verts.erase(m.triangles.verts.begin() + 4);
  m.triangles.ref.pop_back();
  refused(m, {"body.mesh", "not closed", "(3 in all)"});

  m = test::cube_surface(2);
  m.triangles.verts[6][2] = m.triangles.verts[6][0];
  refused(m, {"triangle 7 "});

  m = test::cube_surface(2);
  const auto& t = m.triangles.verts[2];
  m.coords[idx(t[0])] = 0.5 * (m.coords[idx(t[1])] + m.coords[idx(t[2])]);
  refused(m, {"no area"});

  m = test::cube_surface(2);
  const auto copy = m.triangles.verts[3];
  test::add_triangle(m, copy[1], copy[2], copy[0], 1);
  refused(m, {"triangles 4 and 49 ", "same vertices"});

  m = test::cube_surface(2);
  m.coords[5].y = std::nan("");
  refused(m, {"vertex 6 ", "not finite"});

  // two cubes that share an edge
  refused(test::voxel_surface(2, 0.5, [](int i, int j, int k) { return k == 0 && i == j; }),
          {"vertices ", "triangles ", "must have two"});
}

TEST(WindingNumber, TellsInsideFromOutside) {
  const MeshSlice m = test::sphere(2);
  EXPECT_NEAR(winding_number(m.coords, m.triangles.verts, {0.2, 0.3, -0.4}), 1, 1e-12);
  EXPECT_NEAR(winding_number(m.coords, m.triangles.verts, {0.9, 0.9, 0}), 0, 1e-12);
}

}  // namespace
}  // namespace skein
