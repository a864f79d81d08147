// The curved patches: planes stay planes, spheres and tori are met with the order that cubics have, no kinks.
#include "geometry/reference_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "tests/geometry/curved_surfaces.hpp"

namespace skein::test {
namespace {

using Weights = std::array<double, 3>;

/// Calls visit(point of the surface, normal there) at points inside and on the sides of all triangles.
template <class Visit>
void sample(const ReferenceSurface& s, Visit&& visit) {
  for (std::int32_t t = 0; t < std::ssize(s.input().triangles); ++t) {
    for (int i = 0; i <= 6; ++i) {
      for (int k = 0; i + k <= 6; ++k) visit(t, Weights{(6 - i - k) / 6.0, i / 6.0, k / 6.0});
    }
  }
}

struct Errors {
  double mean = 0, largest = 0;
};
template <class Distance>
Errors errors(const SurfaceInput& input, SurfaceShape shape, Distance&& distance) {
  const ReferenceSurface s(input, shape);
  Errors e;
  double n = 0;
  sample(s, [&](std::int32_t t, const Weights& w) {
    const double d = distance(s.evaluate(t, w));
    e.largest = std::max(e.largest, d);
    e.mean += d;
    n += 1;
  });
  e.mean /= n;
  return e;
}
double off_sphere(Vec3 x) { return std::abs(norm(x) - 1); }

TEST(ReferenceSurface, IsNearerToASphereThanFacets) {
  double before = 0;
  for (const int n : {3, 6, 12, 24}) {
    const Errors flat = errors(sphere_surface(n), SurfaceShape::kFacets, off_sphere);
    const Errors curved = errors(sphere_surface(n), SurfaceShape::kPatches, off_sphere);
    EXPECT_LT(20 * curved.mean, flat.mean) << n;
    EXPECT_LT(20 * curved.largest, flat.largest) << n;
    if (before > 0) {
      EXPECT_GT(std::log2(before / curved.largest), 3) << n;
    }
    before = curved.largest;
    RecordProperty("sphere_" + std::to_string(12 * n * n), std::to_string(curved.largest));
  }
}

TEST(ReferenceSurface, IsNearerToATorusThanFacets) {
  const Torus torus;
  double before = 0;
  for (const int n : {12, 24, 48, 96}) {
    const auto distance = [&](Vec3 x) { return torus.distance(x); };
    const Errors flat = errors(torus.surface(2 * n, n), SurfaceShape::kFacets, distance);
    const Errors curved = errors(torus.surface(2 * n, n), SurfaceShape::kPatches, distance);
    EXPECT_LT(4 * curved.mean, flat.mean) << n;
    EXPECT_LT(4 * curved.largest, flat.largest) << n;
    if (before > 0) {
      EXPECT_GT(std::log2(before / curved.largest), 3) << n;
    }
    before = curved.largest;
  }
}

TEST(ReferenceSurface, MeetsACylinderAndItsRims) {
  const SurfaceInput input = grid_surface(24, 3, {true, false}, [](double s, double t) {
    return Vec3{std::cos(2 * std::numbers::pi * s), std::sin(2 * std::numbers::pi * s), t};
  });
  const ReferenceSurface s(input, SurfaceShape::kPatches);
  const double facets = 1 - std::cos(std::numbers::pi / 24);
  sample(s, [&](std::int32_t t, const Weights& w) {
    const Vec3 x = s.evaluate(t, w);
    EXPECT_LT(std::abs(std::hypot(x.x, x.y) - 1), facets / 50);
    EXPECT_LT(std::abs(s.normal_at(t, w).z), 1e-6);
  });
  for (int i = 0; i < 50; ++i) {  // the rim is found from outside of it
    const double u = 0.13 * i;
    const SurfacePoint p = s.nearest_on_edges({0.97 * std::cos(u), 0.97 * std::sin(u), 0.1}, SurfacePlace::kUnknown);
    EXPECT_LT(std::abs(std::hypot(p.x.x, p.x.y) - 1), facets / 100);
    EXPECT_LT(norm(p.x - Vec3{std::cos(u), std::sin(u), 0}), 1e-3);
    EXPECT_LT(std::abs(dot(p.direction, p.x)), 1e-3);
  }
}

TEST(ReferenceSurface, KeepsPlanesWithCurvedRims) {
  const SurfaceInput disc = grid_surface(16, 4, {true, false}, [](double s, double t) {
    const double r = 0.3 + 0.7 * t;
    return Vec3{r * std::cos(2 * std::numbers::pi * s), 2, r * std::sin(2 * std::numbers::pi * s)};
  });
  const ReferenceSurface s(disc, SurfaceShape::kPatches);
  sample(s, [&](std::int32_t t, const Weights& w) { EXPECT_NEAR(s.evaluate(t, w).y, 2, 1e-14); });
  EXPECT_TRUE(s.nearest({0.5, 2, 0}, SurfacePlace::kUnknown).flat);
}

bool x_on_border(const ReferenceSurface& s, Vec3 x) {
  const SurfaceInput& in = s.input();
  return std::any_of(in.edges.begin(), in.edges.end(), [&](const auto& e) {
    return in.points[static_cast<std::size_t>(e[0])] == x || in.points[static_cast<std::size_t>(e[1])] == x;
  });
}

TEST(ReferenceSurface, NormalsOfQuadricsAreExact) {
  const auto cone = [](double s, double t) {
    const double r = 0.2 + 0.6 * t + 0.01 * std::sin(40 * s), u = 1 + s;
    return Vec3{r * std::cos(u), r * std::sin(u), r};
  };
  const ReferenceSurface on_cone(grid_surface(7, 7, {}, cone), SurfaceShape::kPatches);
  const ReferenceSurface on_sphere(sphere_surface(4), SurfaceShape::kPatches);
  for (std::int32_t t = 0; t < std::ssize(on_cone.input().triangles); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 x =
          on_cone.input().points[static_cast<std::size_t>(on_cone.input().triangles[static_cast<std::size_t>(t)][k])];
      const Vec3 n = normalized({x.x, x.y, -std::hypot(x.x, x.y)});
      // At the border the points are all on one side, and many quadrics nearly fit.
      const bool border = x_on_border(on_cone, x);
      EXPECT_LT(norm(cross(on_cone.normal(t, k), n)), border ? 1e-4 : 1e-5);
    }
  }
  for (std::int32_t t = 0; t < std::ssize(on_sphere.input().triangles); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 x = on_sphere.input()
                         .points[static_cast<std::size_t>(on_sphere.input().triangles[static_cast<std::size_t>(t)][k])];
      EXPECT_LT(norm(cross(on_sphere.normal(t, k), x)), 1e-6);
    }
  }
}

/// The normal of the surface itself, by differences along two directions that stay in the triangle.
Vec3 measured_normal(const ReferenceSurface& s, std::int32_t t, const Weights& w, std::size_t inner) {
  constexpr double kStep = 1e-5;
  const std::size_t j = (inner + 1) % 3, k = (inner + 2) % 3;
  Weights along = w, inwards = w;
  along[j] += kStep, along[k] -= kStep;
  inwards[inner] += kStep, inwards[j] -= kStep / 2, inwards[k] -= kStep / 2;
  const Vec3 x = s.evaluate(t, w);
  return normalized(cross(s.evaluate(t, along) - x, s.evaluate(t, inwards) - x));
}

TEST(ReferenceSurface, HasNoKinksOverItsSides) {
  const ReferenceSurface s(Torus{}.surface(16, 8), SurfaceShape::kPatches);
  std::map<std::array<std::int32_t, 2>, std::pair<Vec3, Vec3>> met;  // point and normal in the middle of a side
  double kink = 0, gap = 0, facet_kink = 0;
  std::map<std::array<std::int32_t, 2>, Vec3> facet;
  for (std::int32_t t = 0; t < std::ssize(s.input().triangles); ++t) {
    const auto& v = s.input().triangles[static_cast<std::size_t>(t)];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      const auto [a, b] = std::minmax(v[j], v[k]);
      Weights w{};
      w[v[j] == a ? j : k] = 0.7, w[v[j] == a ? k : j] = 0.3;
      const Vec3 x = s.evaluate(t, w);
      Vec3 n = measured_normal(s, t, w, i);
      const auto p = [&](std::size_t c) { return s.input().points[static_cast<std::size_t>(v[c])]; };
      const Vec3 of_facet = normalized(cross(p(1) - p(0), p(2) - p(0)));
      if (dot(n, of_facet) < 0) n = -1.0 * n;
      const auto [it, is_new] = met.try_emplace({a, b}, std::pair(x, n));
      if (is_new) {
        facet[{a, b}] = of_facet;
        continue;
      }
      gap = std::max(gap, norm(x - it->second.first));
      kink = std::max(kink, norm(cross(n, it->second.second)));
      facet_kink = std::max(facet_kink, norm(cross(of_facet, facet[{a, b}])));
    }
  }
  EXPECT_LT(gap, 1e-14);
  EXPECT_LT(kink, 2e-4);  // of one-sided differences
  EXPECT_GT(facet_kink, 0.1);
}

TEST(ReferenceSurface, PointsOfItAreTheirOwnNearest) {
  const Torus torus;
  const ReferenceSurface s(torus.surface(48, 24), SurfaceShape::kPatches);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(0, 6.28), off(-0.02, 0.02);
  for (int i = 0; i < 500; ++i) {
    const double u = angle(random), v = angle(random), small = 0.4 + off(random);
    const double r = 1 + small * std::cos(v);
    const Vec3 x{r * std::cos(u), r * std::sin(u), small * std::sin(v)};
    const SurfacePoint p = s.nearest(x, SurfacePlace::kUnknown);
    EXPECT_LT(torus.distance(p.x), 3e-4);
    EXPECT_LT(norm(x - p.x), std::abs(small - 0.4) * 1.001 + 3e-4);
    const SurfacePoint again = s.nearest(p.x, p.place);
    EXPECT_LT(norm(again.x - p.x), 1e-9);
    const std::int32_t beside = s.input().triangles[static_cast<std::size_t>(triangle_of(p.place))][0];
    const SurfacePoint walked = s.nearest(x, s.place_of_point(beside));
    EXPECT_LT(norm(walked.x - p.x), 1e-9);
  }
}

TEST(ReferenceSurface, KeepsToItsSheet) {
  // Two sides of a thin plate, 0.001 apart, joined smoothly at one end only.
  const SurfaceInput plate = grid_surface(40, 4, {}, [](double s, double t) {
    const double l = 2.0031416 * s;  // along the middle line: out, half a circle, back
    if (l < 1) return Vec3{l, t, 0.001};
    if (l > 1.0031416) return Vec3{2.0031416 - l, t, -0.001};
    return Vec3{1 + 0.001 * std::sin((l - 1) * 1000), t, 0.001 * std::cos((l - 1) * 1000)};
  });
  const ReferenceSurface s(plate, SurfaceShape::kFacets);
  const SurfacePoint here = s.nearest({0.2, 0.5, 0.01}, SurfacePlace::kUnknown);
  const SurfacePoint below = s.nearest({0.3, 0.5, -0.01}, here.place);
  EXPECT_NEAR(below.x.z, 0.001, 1e-12);
}

}  // namespace
}  // namespace skein::test
