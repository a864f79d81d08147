// Cubic curves between two points with normals or tangents, of which the surface patches are made.
#pragma once
#include <algorithm>

#include "base/vec3.hpp"

namespace skein {

/// The point at t of the cubic from p0 to p1 with the derivatives m0 and m1 at its ends. @pre 0 <= t <= 1
constexpr Vec3 hermite(Vec3 p0, Vec3 m0, Vec3 p1, Vec3 m1, double t) noexcept {
  const double s = 1 - t;
  return (s * s * (1 + 2 * t)) * p0 + (t * s * s) * m0 + (t * t * (1 + 2 * s)) * p1 + (-t * t * s) * m1;
}
/// Its derivative.
constexpr Vec3 hermite_derivative(Vec3 p0, Vec3 m0, Vec3 p1, Vec3 m1, double t) noexcept {
  const double s = 1 - t;
  return (6 * t * s) * (p1 - p0) + (s * (s - 2 * t)) * m0 + (t * (t - 2 * s)) * m1;
}

/// The derivative at the end of a cubic over the chord d that leaves it in the direction `along` (of any length, not
/// against d). Its length is that with which the cubic meets a circular arc best: chord * 2 / (1 + cos(angle)), an
/// error of sixth order in the angle.
inline Vec3 end_derivative(Vec3 d, Vec3 along) noexcept {
  const double chord = norm(d), length = norm(along);
  if (!(length > 1e-12 * chord)) return d;
  const double cosine = std::max(dot(d, along) / (chord * length), 0.0);
  return (2 * chord / ((1 + cosine) * length)) * along;
}
/// The same for a curve on a surface with the unit normal n there.
inline Vec3 end_derivative_on(Vec3 d, Vec3 n) noexcept { return end_derivative(d, d - dot(d, n) * n); }

}  // namespace skein
