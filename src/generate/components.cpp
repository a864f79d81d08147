// Nesting of shells by winding numbers.
#include "generate/components.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "base/box.hpp"
#include "base/error.hpp"

namespace skein {
namespace {

using Triangle = std::array<GlobalId, 3>;

Vec3 centroid(std::span<const Vec3> coords, const Triangle& t) noexcept {
  return (1.0 / 3.0) * (coords[idx(t[0])] + coords[idx(t[1])] + coords[idx(t[2])]);
}

Vec3 area_vector(std::span<const Vec3> coords, const Triangle& t) noexcept {
  return cross(coords[idx(t[1])] - coords[idx(t[0])], coords[idx(t[2])] - coords[idx(t[0])]);
}

/// Parameter s > 0 at which x + s d meets the triangle, or infinity.
double ray_hit(std::span<const Vec3> coords, const Triangle& t, Vec3 x, Vec3 d) noexcept {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Vec3 a = coords[idx(t[0])];
  const Vec3 e1 = coords[idx(t[1])] - a;
  const Vec3 e2 = coords[idx(t[2])] - a;
  const Vec3 p = cross(d, e2);
  const double determinant = dot(e1, p);
  if (determinant == 0) return kNone;
  const Vec3 r = x - a;
  const double u = dot(r, p) / determinant;
  const Vec3 q = cross(r, e1);
  const double v = dot(d, q) / determinant;
  const double s = dot(e2, q) / determinant;
  // Slightly larger than the triangle: a ray through an edge must not slip between two triangles.
  constexpr double kSlack = 1e-9;
  return u >= -kSlack && v >= -kSlack && u + v <= 1 + kSlack && s > 0 ? s : kNone;
}

/// Halfway from the middle of triangle `t` of a shell to the next triangle of the whole surface, inwards.
Vec3 point_behind(std::span<const Vec3> coords, const Shells& shells, std::size_t shell, std::size_t t) noexcept {
  const Triangle& start = shells.triangles[shell][t];
  const Vec3 x = centroid(coords, start);
  const Vec3 inwards = -1.0 * normalized(area_vector(coords, start));
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < shells.triangles.size(); ++i) {
    for (std::size_t k = 0; k < shells.triangles[i].size(); ++k) {
      if (i == shell && k == t) continue;
      nearest = std::min(nearest, ray_hit(coords, shells.triangles[i][k], x, inwards));
    }
  }
  return std::isfinite(nearest) ? x + (nearest / 2) * inwards : x;
}

}  // namespace

double winding_number(std::span<const Vec3> coords, std::span<const Triangle> triangles, Vec3 x) noexcept {
  double sum = 0;
  for (const Triangle& t : triangles) {
    const Vec3 a = coords[idx(t[0])] - x;
    const Vec3 b = coords[idx(t[1])] - x;
    const Vec3 c = coords[idx(t[2])] - x;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (2 * std::numbers::pi);  // the solid angle is twice the arctangent
}

void find_depths(std::span<const Vec3> coords, Shells& shells) {
  const std::size_t n = shells.triangles.size();
  std::vector<Box> box(n, kEmptyBox);
  for (std::size_t i = 0; i < n; ++i) {
    for (const Triangle& t : shells.triangles[i]) {
      for (const GlobalId v : t) box[i] = join(box[i], coords[idx(v)]);
    }
  }
  shells.depth.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 x = centroid(coords, shells.triangles[i].front());
    for (std::size_t k = 0; k < n; ++k) {
      if (k != i && contains(box[k], x) && winding_number(coords, shells.triangles[k], x) > 0.5) ++shells.depth[i];
    }
  }
}

std::vector<Vec3> find_voids(std::span<const Vec3> coords, const Shells& shells) {
  constexpr std::size_t kTries = 16;
  std::vector<Vec3> voids;
  for (std::size_t i = 0; i < shells.triangles.size(); ++i) {
    if (shells.depth[i] % 2 == 0) continue;
    std::vector<std::size_t> order(shells.triangles[i].size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto area = [&](std::size_t t) { return norm(area_vector(coords, shells.triangles[i][t])); };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return area(a) > area(b); });
    bool found = false;
    for (std::size_t k = 0; k < std::min(kTries, order.size()) && !found; ++k) {
      const Vec3 x = point_behind(coords, shells, i, order[k]);
      double inside = 0;  // the voids and islands round x
      for (const auto& triangles : shells.triangles) inside += winding_number(coords, triangles, x);
      found = std::abs(inside - (shells.depth[i] + 1)) < 0.25 &&
              std::abs(winding_number(coords, shells.triangles[i], x) - 1) < 0.25;
      if (found) voids.push_back(x);
    }
    if (!found) {
      throw Error(ExitCode::kInvalidMesh,
                  fmt::format("no point found inside the inner shell of triangle {}: it has no volume or cuts itself",
                              shells.number[i].front() + 1));
    }
  }
  return voids;
}

}  // namespace skein
