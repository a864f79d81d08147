// The first tetrahedra: conforming to the surface, full volume, voids empty, seeds where spacing needs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "generate/carry_inward.hpp"
#include "generate/seeds.hpp"
#include "generate/surface_check.hpp"
#include "generate/tetgen_volume.hpp"
#include "tests/generate/expect_error.hpp"
#include "tests/support/surfaces.hpp"

/// TetGen loses some arrays when it ends with an error; that is no fault to report when leaks are looked for.
// NOLINTNEXTLINE(bugprone-reserved-identifier): the sanitizer looks for this name.
extern "C" const char* __lsan_default_suppressions() { return "leak:libtet\n"; }

namespace skein {
namespace {

std::vector<Vec3> all_coords(const ClosedSurface& s, const Volume& v) {
  std::vector<Vec3> coords = s.mesh.coords;
  coords.insert(coords.end(), v.added.begin(), v.added.end());
  return coords;
}

/// Every tetrahedron positive, their volumes the surface's, every surface triangle a face of one tetrahedron.
void expect_filled(const ClosedSurface& s, const Volume& v) {
  const std::vector<Vec3> coords = all_coords(s, v);
  double sum = 0;
  for (const auto& t : v.tets) {
    const double six = volume6(coords[idx(t[0])], coords[idx(t[1])], coords[idx(t[2])], coords[idx(t[3])]);
    EXPECT_GT(six, 0);
    sum += six / 6;
  }
  EXPECT_NEAR(sum, s.volume, 1e-10 * s.volume);
}

TEST(FillVolume, FillsSurfacesOfAllKinds) {
  for (const MeshSlice& m : {test::cube_surface(1), test::cube_surface(5), test::l_shape(4), test::hollow_cube(6),
                             test::sphere(3), test::both(test::sphere(2, 4), test::sphere(3, 1)),
                             test::both(test::sphere(2), test::sphere(2, 1, {3, 0, 0}))}) {
    const ClosedSurface s = check_surface(test::mixed_up(m));
    const Volume v = fill_volume(s, {});
    expect_filled(s, v);
    EXPECT_LE(v.added.size(), s.mesh.coords.size());
  }
}

TEST(FillVolume, UsesSeedsInsideOnly) {
  const ClosedSurface s = check_surface(test::hollow_cube(3));
  const Vec3 inside{0.1, 0.2, 0.15};
  const Volume v = fill_volume(s, {{0.5, 0.5, 0.5}, inside, {2, 2, 2}});
  expect_filled(s, v);
  EXPECT_EQ(std::count(v.added_is_seed.begin(), v.added_is_seed.end(), 1), 1);
  EXPECT_NE(std::find(v.added.begin(), v.added.end(), inside), v.added.end());
}

TEST(FillVolume, NamesTrianglesThatCutEachOther) {
  MeshSlice m = test::both(test::cube_surface(2), test::cube_surface(1));
  for (std::size_t v = m.coords.size() - 8; v < m.coords.size(); ++v) m.coords[v] += {0.63, 0.21, 0.17};
  m.path = "crossed.mesh";
  test::expect_error([&] { fill_volume(check_surface(m), {}); }, ExitCode::kInvalidMesh,
                     {"crossed.mesh", "cuts itself", "triangles "});
}

TEST(Seeds, FollowASourceAwayFromTheSurface) {
  const MeshSlice m = test::cube_surface(2);
  const ClosedSurface s = check_surface(m);
  SpacingField f;
  f.sources.push_back({1, {Vec3{0.4, 0.55, 0.6}, {}, {}}, 1e-4, 0.002, 0.004});
  const std::vector<Vec3> seeds = make_seeds(s.mesh, boundary_spacing(s.mesh), f);
  double nearest = 1e300;
  for (const Vec3 x : seeds) nearest = std::min(nearest, distance(f.sources[0], x));
  EXPECT_LT(nearest, 1e-3);
  double complexity = 0;  // the final mesh has about 1.7 times as many vertices
  constexpr double kStep = 1e-5;
  for (double r = kStep / 2; r < 0.1; r += kStep) {
    complexity += 4 * std::numbers::pi * r * r * kStep / std::pow(f.at(f.sources[0].corner[0] + Vec3{r, 0, 0}), 3);
  }
  EXPECT_LT(static_cast<double>(seeds.size()), 0.25 * 1.7 * complexity);
  expect_filled(s, fill_volume(s, seeds));
}

TEST(Seeds, AreFewWhereTheSurfaceIsEven) {
  const ClosedSurface s = check_surface(test::cube_surface(10));
  EXPECT_LE(make_seeds(s.mesh, boundary_spacing(s.mesh), {}).size(), 64U);
}

TEST(CarryInward, GrowsSlowlyOverAThousandToOne) {
  const MeshSlice m = test::both(test::cube_surface(2), test::sphere(3, 1e-3, {0.5, 0.5, 0.5}));
  const ClosedSurface s = check_surface(m);
  std::vector<double> spacing = boundary_spacing(s.mesh);
  const double largest = *std::max_element(spacing.begin(), spacing.end());
  EXPECT_GT(largest / *std::min_element(spacing.begin(), spacing.end()), 1000);
  const Volume v = fill_volume(s, make_seeds(s.mesh, spacing, {}));
  expect_filled(s, v);
  const std::vector<Vec3> coords = all_coords(s, v);
  const std::size_t fixed = spacing.size();
  const std::vector<double> before = spacing;
  spacing.resize(coords.size(), largest);
  constexpr double kGrowth = 0.3;
  carry_inward(coords, v.tets, fixed, kGrowth, spacing);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), spacing.begin()));
  for (const auto& t : v.tets) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        if (idx(t[a]) < fixed) continue;
        const double length = norm(coords[idx(t[a])] - coords[idx(t[b])]);
        EXPECT_LE(spacing[idx(t[a])], (spacing[idx(t[b])] + kGrowth * length) * (1 + 1e-12));
      }
    }
  }
  // not much finer than the shortest way allows: the edges' way is longer, but not by much
  for (std::size_t i = fixed; i < coords.size(); ++i) {
    const double d = norm(coords[i] - Vec3{0.5, 0.5, 0.5}) - 1e-3;
    EXPECT_GE(spacing[i], std::min(largest, kGrowth * d) * 0.99);
    EXPECT_LE(spacing[i], 3e-4 + 2 * kGrowth * d);
  }
}

}  // namespace
}  // namespace skein
