// A whole mesh of cells, the same on every rank: what all test meshes of tetrahedra are made of.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "mesh/tet_mesh.hpp"

namespace skein::test {

/// As a file has it; numbers from 0.
struct WholeMesh {
  std::vector<Vec3> coords;
  std::vector<std::array<std::int64_t, 4>> tets;
  std::vector<std::int32_t> tet_ref;
  std::vector<std::array<std::int64_t, 3>> tris;
  std::vector<std::int32_t> tri_ref;
  std::vector<std::array<std::int64_t, 2>> edges;
  std::vector<std::int32_t> edge_ref;
  std::vector<std::int64_t> corners, ridges, required_verts, required_tris;
};

/// The vertices of n^3 cells of the unit cube: (i, j, k), each 0 .. n, x fastest.
struct Lattice {
  int n;
  [[nodiscard]] std::int64_t number(int i, int j, int k) const {
    return (static_cast<std::int64_t>(k) * (n + 1) + j) * (n + 1) + i;
  }
  [[nodiscard]] std::array<int, 3> place(std::int64_t number) const {
    const std::int64_t s = n + 1;
    return {static_cast<int>(number % s), static_cast<int>(number / s % s), static_cast<int>(number / s / s)};
  }
};

/// n^3 cells of the unit cube, six positive tetrahedra round a diagonal each (cell by cell, x fastest), reference 1.
/// No triangles.
inline WholeMesh cells(int n) {
  const Lattice lattice{n};
  WholeMesh w;
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) w.coords.push_back({double(i) / n, double(j) / n, double(k) / n});
    }
  }
  constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int cell = 0; cell < n * n * n; ++cell) {
    for (const auto& order : kOrders) {
      std::array<int, 3> p{cell % n, cell / n % n, cell / n / n};
      std::array<std::int64_t, 4> t{lattice.number(p[0], p[1], p[2])};
      for (std::size_t a = 0; a < 3; ++a) {
        ++p[order[a]];
        t[a + 1] = lattice.number(p[0], p[1], p[2]);
      }
      const auto x = [&](std::size_t v) { return w.coords[t[v]]; };
      if (volume6(x(0), x(1), x(2), x(3)) < 0) std::swap(t[2], t[3]);
      w.tets.push_back(t);
    }
  }
  w.tet_ref.assign(w.tets.size(), 1);
  return w;
}

/// The side of the unit cube (0 .. 5: x=0, x=1, y=0, ...) on which all these points lie; -1: on none.
template <std::size_t N>
int side_of_cube(const std::array<Vec3, N>& points) {
  const std::array<double Vec3::*, 3> axes{&Vec3::x, &Vec3::y, &Vec3::z};
  for (int a = 0; a < 3; ++a) {
    for (int end = 0; end < 2; ++end) {
      if (std::ranges::all_of(points, [&](Vec3 p) { return p.*axes[a] == end; })) return 2 * a + end;
    }
  }
  return -1;
}
template <std::size_t N>
bool in_middle_plane(const std::array<Vec3, N>& points) {
  return std::ranges::all_of(points, [](Vec3 p) { return p.x == 0.5; });
}

enum class Regions {
  kOne,       ///< reference 1
  kTwo,       ///< cells with x >= 1/2 have reference 2; n even
  kTwoTagged  ///< and the faces between have reference 7
};

/// cells(n) with the triangles of the hull: sides have references 1 to 6 (x=0, x=1, y=0, ...).
inline WholeMesh cube(int n, Regions regions = Regions::kOne) {
  WholeMesh w = cells(n);
  for (std::size_t t = 0; t < w.tets.size(); ++t) {
    const auto cell = static_cast<int>(t / 6);
    if (regions != Regions::kOne && 2 * (cell % n) >= n) w.tet_ref[t] = 2;
    for (const auto& f : kFaceVerts) {
      std::array<std::int64_t, 3> v;
      std::array<Vec3, 3> x;
      for (std::size_t c = 0; c < 3; ++c) {
        v[c] = w.tets[t][f[c]];
        x[c] = w.coords[v[c]];
      }
      int ref = side_of_cube(x) + 1;
      if (ref == 0 && regions == Regions::kTwoTagged && w.tet_ref[t] == 1 && in_middle_plane(x)) ref = 7;
      if (ref == 0) continue;
      w.tris.push_back(v);
      w.tri_ref.push_back(ref);
    }
  }
  return w;
}

}  // namespace skein::test
