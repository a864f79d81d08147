// Volume generation as a whole: valid, the surface's volume and patches, the wanted spacing, the same on any rank
// count.
#include <gtest/gtest.h>

#include <cmath>

#include "dist/reconcile.hpp"
#include "generate/generate.hpp"
#include "generate/slices.hpp"
#include "generate/surface_check.hpp"
#include "mesh/check.hpp"
#include "report/statistics.hpp"
#include "tests/generate/expect_error.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/world.hpp"

namespace skein {
namespace {

using test::world;

MeshSlice sliced(const MeshSlice& whole) { return scatter_mesh(world(), world().is_root() ? whole : MeshSlice{}); }

double triangle_area(const MeshSlice& m, std::int32_t ref) {
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.verts.size(); ++t) {
    if (m.triangles.ref[t] != ref) continue;
    const auto& v = m.triangles.verts[t];
    sum += norm(cross(m.coords[idx(v[1])] - m.coords[idx(v[0])], m.coords[idx(v[2])] - m.coords[idx(v[0])])) / 2;
  }
  return sum;
}

struct Generated {
  DistMesh dist;
  MeshStatistics stats;
};

Generated run(const Comm& comm, const MeshSlice& surface, const GenerateOptions& options) {
  PhaseLog log(comm, PhaseLog::Output::kQuiet);
  Generated g{generate(comm, surface, options, log), {}};
  g.stats = statistics(comm, g.dist, Measure::kInMetric);
  return g;
}

/// Share of local edges, in %, whose length over the spacing at their middle is in [1/sqrt 2, sqrt 2].
double share_of_field(const Comm& comm, const DistMesh& dist, const SpacingField& field) {
  std::int64_t good = 0, all = 0;
  for (const auto& v : dist.mesh.tet2vert) {
    for (const auto& e : kEdgeVerts) {
      const Vec3 a = dist.mesh.coords[v[e[0]]];
      const Vec3 b = dist.mesh.coords[v[e[1]]];
      const double l = norm(b - a) / field.at(0.5 * (a + b));
      ++all;
      good += l > std::sqrt(0.5) && l < std::sqrt(2.0) ? 1 : 0;
    }
  }
  return 100.0 * static_cast<double>(comm.sum(good)) / static_cast<double>(comm.sum(all));
}

void expect_volume_mesh(const Generated& g, const MeshSlice& whole) {
  EXPECT_EQ(check(g.dist.mesh), "");
  EXPECT_NO_THROW(reconcile(world(), g.dist));
  EXPECT_EQ(g.stats.nonpositive_tets, 0);
  for (std::size_t p = 0; p < g.dist.mesh.patch_ref.size(); ++p) {
    const double area = world().sum(patch_area(g.dist.mesh, static_cast<int>(p)));
    const double wanted = triangle_area(whole, g.dist.mesh.patch_ref[p]);
    EXPECT_GT(wanted, 0) << "reference " << g.dist.mesh.patch_ref[p];
    EXPECT_NEAR(area, wanted, 1e-9 * wanted);
  }
}

TEST(Generate, FillsFlatSidedSurfacesExactly) {
  for (const MeshSlice& whole : {test::cube_surface(6), test::l_shape(6), test::hollow_cube(6)}) {
    const Generated g = run(world(), sliced(test::mixed_up(whole)), {});
    expect_volume_mesh(g, whole);
    EXPECT_NEAR(g.stats.volume, check_surface(whole).volume, 1e-10);
    EXPECT_GT(g.stats.length.unit_share, 80);
    EXPECT_GT(g.stats.quality.p01, 0.1);
  }
}

std::int64_t hull_faces(const Generated& g) {
  std::int64_t hull = 0;
  for (const auto& tags : g.dist.mesh.face_tag) {
    for (const FaceTag t : tags) hull += is_hull(t) ? 1 : 0;
  }
  return world().sum(hull);
}

TEST(Generate, KeepsTheSurfaceWhenToldAndWhereNoSizesAreGiven) {
  const MeshSlice whole = test::sphere(3);
  GenerateOptions told, silent, remeshed;
  told.surface = GenerateOptions::Surface::kKept;
  told.size_max = 0.15;
  for (const GenerateOptions& options : {told, silent}) {
    const Generated g = run(world(), sliced(whole), options);
    expect_volume_mesh(g, whole);
    EXPECT_NEAR(g.stats.volume, check_surface(whole).volume, 1e-10);
    EXPECT_EQ(hull_faces(g), whole.triangles.total);
  }
  remeshed.size_max = 0.15;
  EXPECT_NE(hull_faces(run(world(), sliced(whole), remeshed)), whole.triangles.total);
}

TEST(Generate, MeetsTheSpacingOfSources) {
  const MeshSlice whole = test::cube_surface(4);
  GenerateOptions options;
  options.sources.sources.push_back({1, {Vec3{0.3, 0.4, 0.5}, {}, {}}, 0.03, 0.05, 0.25});
  options.size_max = 0.2;
  const Generated g = run(world(), sliced(whole), options);
  expect_volume_mesh(g, whole);
  EXPECT_NEAR(g.stats.volume, 1, 1e-10);
  EXPECT_GT(g.stats.length.unit_share, 80);
  SpacingField field = options.sources;
  field.size_max = options.size_max;
  EXPECT_GT(share_of_field(world(), g.dist, field), 75);
}

TEST(Generate, GradesOverAThousandToOne) {
  const MeshSlice whole = test::both(test::cube_surface(2), test::sphere(2, 1e-3, {0.5, 0.5, 0.5}));
  const Generated g = run(world(), sliced(whole), {});
  EXPECT_EQ(check(g.dist.mesh), "");
  EXPECT_EQ(g.stats.nonpositive_tets, 0);
  EXPECT_GT(g.stats.length.unit_share, 75);
  EXPECT_LT(g.stats.tets, 60000);  // growth 0.3 from 3e-4 to 0.5 needs that order, not millions
}

TEST(Generate, GivesTheSameMeshStatisticsOnOneRank) {
  const MeshSlice whole = test::sphere(3);
  GenerateOptions options;
  options.size_max = 0.15;
  const Generated g = run(world(), sliced(whole), options);
  const Comm self = Comm::self();
  const Generated one = run(self, whole, options);
  EXPECT_NEAR(static_cast<double>(g.stats.tets), static_cast<double>(one.stats.tets),
              0.05 * static_cast<double>(one.stats.tets));
  EXPECT_NEAR(g.stats.length.unit_share, one.stats.length.unit_share, 3);
  EXPECT_NEAR(g.stats.quality.mean, one.stats.quality.mean, 0.03);
  EXPECT_NEAR(g.stats.volume, one.stats.volume, 0.01 * one.stats.volume);
}

TEST(Generate, FailsOnAllRanksAlike) {
  MeshSlice open = test::cube_surface(2);
  open.path = "open.mesh";
  open.triangles.verts.pop_back();
  open.triangles.ref.pop_back();
  --open.triangles.total;
  const MeshSlice slice = sliced(open);
  test::expect_error([&] { run(world(), slice, {}); }, ExitCode::kInvalidMesh, {"open.mesh", "not closed"});
  GenerateOptions options;
  options.growth = 0;
  test::expect_error([&] { run(world(), slice, options); }, ExitCode::kUsage, {"growth"});
}

}  // namespace
}  // namespace skein
