// Exact orientation of four points: a floating-point filter, and the exact kernel of [CGAL] where it cannot decide.
#pragma once
#include <algorithm>
#include <cmath>

#include "base/vec3.hpp"

namespace skein {

/// The exact sign, always computed with CGAL's exact-predicates kernel (slow).
int orient3d_exact(Vec3 a, Vec3 b, Vec3 c, Vec3 d) noexcept;

/// Exact sign (-1, 0, 1) of det(b-a, c-a, d-a), i.e. of the volume of the tetrahedron a b c d.
/// The filter's bound is (8 + small) epsilon times the product of the largest differences per axis, times 6 terms;
/// the bound is that of [Shewchuk1997], stage A, with the permanent replaced by its upper bound.
inline int orient3d_sign(Vec3 a, Vec3 b, Vec3 c, Vec3 d) noexcept {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double det = dot(cross(u, v), w);
  const double mx = std::max({std::abs(u.x), std::abs(v.x), std::abs(w.x)});
  const double my = std::max({std::abs(u.y), std::abs(v.y), std::abs(w.y)});
  const double mz = std::max({std::abs(u.z), std::abs(v.z), std::abs(w.z)});
  const double bound = 6 * 8.0e-16 * (mx * my * mz);
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return orient3d_exact(a, b, c, d);
}

}  // namespace skein
