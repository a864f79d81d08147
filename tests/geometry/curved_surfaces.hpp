// Triangulations of surfaces whose true shape is known.
#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "geometry/reference_surface.hpp"

namespace skein::test {

/// A grid of n by m cells, each cut in two (alternating diagonals), put where `at(i / n, j / m)` says. Closed in a
/// direction where `wrap` says so.
struct Wrap {
  bool first = false, second = false;
};
inline SurfaceInput grid_surface(int n, int m, Wrap wrap, const std::function<Vec3(double, double)>& at) {
  SurfaceInput s;
  const int columns = wrap.first ? n : n + 1, rows = wrap.second ? m : m + 1;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) s.points.push_back(at(static_cast<double>(i) / n, static_cast<double>(j) / m));
  }
  const auto point = [&](int i, int j) { return i % columns + columns * (j % rows); };
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      const std::int32_t a = point(i, j), b = point(i + 1, j), c = point(i + 1, j + 1), d = point(i, j + 1);
      if ((i + j) % 2 == 0) {
        s.triangles.push_back({a, b, c});
        s.triangles.push_back({a, c, d});
      } else {
        s.triangles.push_back({a, b, d});
        s.triangles.push_back({b, c, d});
      }
    }
  }
  for (int i = 0; i < n && !wrap.second; ++i) {
    for (const int j : {0, m}) s.edges.push_back({point(i, j), point(i + 1, j)});
  }
  for (int j = 0; j < m && !wrap.first; ++j) {
    for (const int i : {0, n}) s.edges.push_back({point(i, j), point(i, j + 1)});
  }
  s.patch.assign(s.triangles.size(), 0);
  s.is_corner.assign(s.points.size(), 0);
  if (!wrap.first && !wrap.second) {
    for (const int i : {0, n}) {
      for (const int j : {0, m}) s.is_corner[static_cast<std::size_t>(point(i, j))] = 1;
    }
  }
  return s;
}

/// Torus round the z-axis; 2 n m triangles.
struct Torus {
  double large = 1, small = 0.4;
  [[nodiscard]] SurfaceInput surface(int n, int m) const {
    return grid_surface(n, m, {true, true}, [this](double s, double t) {
      const double u = 2 * std::numbers::pi * s, v = 2 * std::numbers::pi * t, r = large + small * std::cos(v);
      return Vec3{r * std::cos(u), r * std::sin(u), small * std::sin(v)};
    });
  }
  [[nodiscard]] double distance(Vec3 x) const {
    return std::abs(std::hypot(std::hypot(x.x, x.y) - large, x.z) - small);
  }
};

/// The sphere of radius 1, from a cube whose sides have n by n cells; 12 n^2 triangles, no features.
inline SurfaceInput sphere_surface(int n) {
  SurfaceInput s;
  const auto key = [](Vec3 x) {
    return std::array{std::lround(x.x * 1e6), std::lround(x.y * 1e6), std::lround(x.z * 1e6)};
  };
  std::map<std::array<long, 3>, std::int32_t> number;
  const auto point = [&](Vec3 x) {
    const auto [it, is_new] = number.try_emplace(key(x), static_cast<std::int32_t>(s.points.size()));
    const auto bent = [](double t) { return std::tan(t * std::numbers::pi / 4); };
    if (is_new) s.points.push_back(normalized({bent(x.x), bent(x.y), bent(x.z)}));
    return it->second;
  };
  for (int side = 0; side < 6; ++side) {
    const double to = side % 2 == 0 ? 1 : -1;
    const auto at = [&](int i, int j) {
      const double u = 2.0 * i / n - 1, v = to * (2.0 * j / n - 1);
      return point(side / 2 == 0 ? Vec3{to, u, v} : side / 2 == 1 ? Vec3{v, to, u} : Vec3{u, v, to});
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }
  s.patch.assign(s.triangles.size(), 0);
  s.is_corner.assign(s.points.size(), 0);
  return s;
}

}  // namespace skein::test
