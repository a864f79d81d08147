// A surface gathered to rank 0 and scattered again is the same; a whole mesh comes back as even slices.
#include "generate/slices.hpp"

#include <gtest/gtest.h>

#include "comm/file.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/world.hpp"

namespace skein {
namespace {

using test::world;

MeshSlice whole_mesh() {
  MeshSlice m = test::sphere(2);
  m.path = "sphere.mesh";
  for (std::int32_t i = 0; i < 7; ++i) {
    m.edges.verts.push_back({GlobalId{i}, GlobalId{i + 1}});
    m.edges.ref.push_back(10 * i);
  }
  m.edges.total = 7;
  m.ridges = {1, 0, {GlobalId{4}}};
  m.corners = {2, 0, {GlobalId{1}, GlobalId{5}}};
  for (std::int64_t i = 0; i < 40; ++i) {
    m.tets.verts.push_back({GlobalId{i}, GlobalId{i + 1}, GlobalId{i + 2}, GlobalId{i + 3}});
    m.tets.ref.push_back(static_cast<std::int32_t>(i));
  }
  m.tets.total = 40;
  return m;
}

TEST(Slices, ScatterGivesEvenSlices) {
  const MeshSlice whole = whole_mesh();
  const MeshSlice slice = scatter_mesh(world(), world().is_root() ? whole : MeshSlice{});
  const Slice verts = even_slice(whole.total_verts, world().rank(), world().size());
  EXPECT_EQ(slice.path, whole.path);
  EXPECT_EQ(slice.total_verts, whole.total_verts);
  EXPECT_EQ(slice.first_vert, verts.first);
  EXPECT_EQ(static_cast<std::int64_t>(slice.coords.size()), verts.size());
  EXPECT_EQ(slice.vert_ref.size(), slice.coords.size());
  const Slice tets = even_slice(40, world().rank(), world().size());
  EXPECT_EQ(slice.tets.total, 40);
  EXPECT_EQ(slice.tets.first, tets.first);
  EXPECT_EQ(static_cast<std::int64_t>(slice.tets.verts.size()), tets.size());
  for (std::size_t i = 0; i < slice.tets.verts.size(); ++i) {
    EXPECT_EQ(slice.tets.verts[i], whole.tets.verts[static_cast<std::size_t>(tets.first) + i]);
    EXPECT_EQ(slice.tets.ref[i], whole.tets.ref[static_cast<std::size_t>(tets.first) + i]);
  }
}

TEST(Slices, GatherUndoesScatter) {
  const MeshSlice whole = whole_mesh();
  const MeshSlice back = gather_surface(world(), scatter_mesh(world(), world().is_root() ? whole : MeshSlice{}));
  EXPECT_TRUE(back.tets.verts.empty());
  if (!world().is_root()) {
    EXPECT_TRUE(back.coords.empty());
    EXPECT_TRUE(back.triangles.verts.empty());
    return;
  }
  EXPECT_EQ(back.coords, whole.coords);
  EXPECT_EQ(back.triangles.verts, whole.triangles.verts);
  EXPECT_EQ(back.triangles.ref, whole.triangles.ref);
  EXPECT_EQ(back.edges.verts, whole.edges.verts);
  EXPECT_EQ(back.edges.ref, whole.edges.ref);
  EXPECT_EQ(back.ridges.verts, whole.ridges.verts);
  EXPECT_EQ(back.corners.verts, whole.corners.verts);
}

TEST(Slices, ValuesGoWithTheirVertices) {
  std::vector<double> whole;
  for (int i = 0; i < 33 * 2; ++i) whole.push_back(i);
  const std::vector<double> own = scatter_values(world(), 33, 2, world().is_root() ? whole : std::vector<double>{});
  const Slice verts = even_slice(33, world().rank(), world().size());
  ASSERT_EQ(static_cast<std::int64_t>(own.size()), 2 * verts.size());
  for (std::size_t i = 0; i < own.size(); ++i)
    EXPECT_EQ(own[i], static_cast<double>(2 * verts.first) + static_cast<double>(i));
}

}  // namespace
}  // namespace skein
