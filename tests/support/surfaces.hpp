// Closed surfaces for the tests: unions of voxels, and a sphere.
#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "mesh/mesh_slice.hpp"

namespace skein::test {

inline void add_triangle(MeshSlice& m, GlobalId a, GlobalId b, GlobalId c, std::int32_t ref) {
  m.triangles.verts.push_back({a, b, c});
  m.triangles.ref.push_back(ref);
  ++m.triangles.total;
}

inline GlobalId add_vertex(MeshSlice& m, Vec3 x) {
  m.coords.push_back(x);
  m.vert_ref.push_back(0);
  return to_id<GlobalId>(m.total_verts++);
}

using Inside = std::function<bool(int, int, int)>;

/// The boundary of the voxels (side h, indices 0 .. n-1 per axis) that are inside, oriented outwards; the reference of
/// a triangle is 1 .. 6 by its normal (-x, +x, -y, +y, -z, +z).
inline MeshSlice voxel_surface(int n, double h, const Inside& inside) {
  MeshSlice m;
  std::map<std::array<int, 3>, GlobalId> number;
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [it, is_new] = number.try_emplace(p, kNoGlobal);
    if (is_new) it->second = add_vertex(m, {h * p[0], h * p[1], h * p[2]});
    return it->second;
  };
  const auto has = [&](std::array<int, 3> c) {
    for (const int i : c) {
      if (i < 0 || i >= n) return false;
    }
    return inside(c[0], c[1], c[2]);
  };
  for (int i = 0; i < n * n * n; ++i) {
    const std::array<int, 3> c{i % n, i / n % n, i / n / n};
    if (!has(c)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        std::array<int, 3> other = c;
        other[axis] += side == 0 ? -1 : 1;
        if (has(other)) continue;
        std::array<int, 3> p = c;
        p[axis] += side;
        auto q = p, r = p, s = p;
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        ++q[u], ++r[u], ++r[v], ++s[v];
        if (side == 0) std::swap(q, s);
        const auto ref = static_cast<std::int32_t>(2 * static_cast<int>(axis) + side + 1);
        const bool flip = (c[0] + c[1] + c[2]) % 2 == 1;  // both diagonals occur
        const GlobalId a = vertex(p), b = vertex(q), d = vertex(r), e = vertex(s);
        if (flip) {
          add_triangle(m, a, b, e, ref);
          add_triangle(m, b, d, e, ref);
        } else {
          add_triangle(m, a, b, d, ref);
          add_triangle(m, a, d, e, ref);
        }
      }
    }
  }
  return m;
}

inline MeshSlice cube_surface(int n) {
  return voxel_surface(n, 1.0 / n, [](int, int, int) { return true; });
}
/// The unit cube without its quarter x > 1/2, y > 1/2. @pre n is even.
inline MeshSlice l_shape(int n) {
  return voxel_surface(n, 1.0 / n, [n](int i, int j, int) { return 2 * i < n || 2 * j < n; });
}
/// The unit cube with a cube-shaped void of side 1/3. @pre n is a multiple of 3.
inline MeshSlice hollow_cube(int n) {
  const auto middle = [n](int i) { return 3 * i >= n && 3 * i < 2 * n; };
  return voxel_surface(n, 1.0 / n, [middle](int i, int j, int k) { return !(middle(i) && middle(j) && middle(k)); });
}

/// An octahedron split `levels` times and blown up to radius r about c.
inline MeshSlice sphere(int levels, double r = 1, Vec3 c = {}) {
  MeshSlice m;
  std::array<GlobalId, 6> v{};
  for (std::size_t i = 0; i < 6; ++i) {
    const double s = i % 2 == 0 ? 1 : -1;
    v[i] = add_vertex(m, {i / 2 == 0 ? s : 0, i / 2 == 1 ? s : 0, i / 2 == 2 ? s : 0});
  }
  for (std::size_t i = 0; i < 8; ++i) {
    const GlobalId x = v[i & 1], y = v[2 + (i >> 1 & 1)], z = v[4 + (i >> 2)];
    const bool odd = ((i & 1) + (i >> 1 & 1) + (i >> 2)) % 2 == 1;
    add_triangle(m, x, odd ? z : y, odd ? y : z, 7);
  }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<GlobalId, GlobalId>, GlobalId> middle;
    const auto mid = [&](GlobalId a, GlobalId b) {
      const auto [it, is_new] = middle.try_emplace(std::minmax(a, b), kNoGlobal);
      if (is_new) it->second = add_vertex(m, normalized(m.coords[idx(a)] + m.coords[idx(b)]));
      return it->second;
    };
    const auto old = m.triangles.verts;
    m.triangles = {};
    for (const auto& t : old) {
      const GlobalId ab = mid(t[0], t[1]), bc = mid(t[1], t[2]), ca = mid(t[2], t[0]);
      add_triangle(m, t[0], ab, ca, 7);
      add_triangle(m, ab, t[1], bc, 7);
      add_triangle(m, ca, bc, t[2], 7);
      add_triangle(m, ab, bc, ca, 7);
    }
  }
  for (Vec3& x : m.coords) x = c + r * x;
  return m;
}

/// Both surfaces side by side (their numbers one behind the other).
inline MeshSlice both(MeshSlice a, const MeshSlice& b) {
  const std::int64_t n = a.total_verts;
  for (const Vec3 x : b.coords) add_vertex(a, x);
  for (std::size_t t = 0; t < b.triangles.verts.size(); ++t) {
    const auto& v = b.triangles.verts[t];
    add_triangle(a, GlobalId{num(v[0]) + n}, GlobalId{num(v[1]) + n}, GlobalId{num(v[2]) + n}, b.triangles.ref[t]);
  }
  return a;
}

/// Every third triangle turned round.
inline MeshSlice mixed_up(MeshSlice m) {
  for (std::size_t t = 0; t < m.triangles.verts.size(); t += 3) {
    std::swap(m.triangles.verts[t][0], m.triangles.verts[t][1]);
  }
  return m;
}

}  // namespace skein::test
