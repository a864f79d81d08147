// Adapting on a curved boundary: vertices come onto it, coarse facets stay near it, chains of passes do not drift away.
#include "api/on_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dist/gather_slices.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// A ball of radius 1 in one patch, of the cells of a cube.
WholeMesh ball(int n) {
  WholeMesh w = cube(n);
  for (Vec3& x : w.coords) {
    const Vec3 p{2 * x.x - 1, 2 * x.y - 1, 2 * x.z - 1};
    const double most = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (most > 0) x = (most / norm(p)) * p;
    if (most == 0) x = p;
  }
  w.tri_ref.assign(w.tris.size(), 1);
  return w;
}

struct Adapted {
  MeshSlice mesh;
  AdaptationReport found;
};
/// Collective. Adapts to one size everywhere.
Adapted adapted(const MeshSlice& file, double size, const AdaptationOptions& with = {},
                const MeshSlice& geometry = {}) {
  AdaptationInput in;
  in.mesh = file;
  in.geometry = geometry;
  in.values.path = "size", in.values.total = file.total_verts, in.values.first = file.first_vert;
  in.values.kinds = {FieldKind::kTensor}, in.values.width = 6;
  const double l = -2 * std::log(size);
  for (std::size_t i = 0; i < file.coords.size(); ++i)
    in.values.values.insert(in.values.values.end(), {l, 0, l, 0, 0, l});
  AdaptationOptions options = with;
  options.metric.source = MetricSource::kTensors;
  PhaseLog log(world(), PhaseLog::Output::kQuiet);
  Adapted run;
  DistMesh dist = run_adaptation(world(), std::move(in), options, log, {}, &run.found);
  run.mesh = to_slices(world(), dist);
  return run;
}

double volume(const Adapted& run) {
  const DistMesh dist = distribute(world(), run.mesh);
  return invariants(world(), dist).hull_volume;
}

TEST(OnSurface, RefinedBallBecomesRound) {
  const MeshSlice coarse = slices(world(), ball(6));
  AdaptationOptions flat;
  flat.geometry = SurfaceShape::kFacets;
  const Adapted facets = adapted(coarse, 0.12, flat), patches = adapted(coarse, 0.12);
  ASSERT_TRUE(patches.found.surface.has_value());
  EXPECT_EQ(patches.found.surface->total().vertices_off, 0);
  const double whole = 4 * std::numbers::pi / 3;
  EXPECT_LT(4 * std::abs(volume(patches) - whole), std::abs(volume(facets) - whole));
}

TEST(OnSurface, CoarsenedBallKeepsItsVolume) {
  const MeshSlice fine = slices(world(), ball(10));
  const double before = invariants(world(), distribute(world(), fine)).hull_volume;
  for (const SurfaceShape shape : {SurfaceShape::kFacets, SurfaceShape::kPatches}) {
    AdaptationOptions o;
    o.geometry = shape;
    const Adapted run = adapted(fine, 1.5, o);
    EXPECT_NEAR(volume(run), before, 0.01 * before);
    EXPECT_LT(run.mesh.total_verts, fine.total_verts / 2);
    o.deviation = {0.02, 0};  // wider: fewer vertices
    o.end_check.curved = 0.5;
    EXPECT_LT(adapted(fine, 1.5, o).mesh.total_verts, run.mesh.total_verts);
  }
}

TEST(OnSurface, ChainStaysOnTheFirstSurface) {
  const MeshSlice first = slices(world(), ball(6));
  Adapted pass = adapted(first, 0.25, {}, first);
  const double off = pass.found.surface->total().largest;
  for (const double size : {0.2, 0.3, 0.2, 0.25}) {
    pass = adapted(pass.mesh, size, {}, first);
    EXPECT_EQ(pass.found.surface->total().vertices_off, 0);
  }
  EXPECT_LT(pass.found.surface->total().largest, 1.2 * off);
}

TEST(OnSurface, CubeIsTheSameWithPatchesAndFacets) {
  const MeshSlice file = slices(world(), cube(4));
  AdaptationOptions flat;
  flat.geometry = SurfaceShape::kFacets;
  const Adapted facets = adapted(file, 0.13, flat), patches = adapted(file, 0.13);
  EXPECT_EQ(facets.mesh.coords, patches.mesh.coords);
  EXPECT_EQ(facets.mesh.tets.verts, patches.mesh.tets.verts);
  EXPECT_LT(patches.found.surface->total().largest, 1e-14);
}

}  // namespace
}  // namespace skein::test
