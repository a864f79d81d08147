// Points and vectors in space, double precision.
#pragma once
#include <cmath>

namespace skein {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator*(double s, Vec3 a) noexcept { return {s * a.x, s * a.y, s * a.z}; }
  constexpr Vec3& operator+=(Vec3 b) noexcept { return *this = *this + b; }
  constexpr Vec3& operator-=(Vec3 b) noexcept { return *this = *this - b; }
  friend constexpr bool operator==(Vec3, Vec3) = default;
};
constexpr double dot(Vec3 a, Vec3 b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(Vec3 a, Vec3 b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec3 a) noexcept { return std::sqrt(dot(a, a)); }
/// Unit vector along a; the zero vector stays zero.
inline Vec3 normalized(Vec3 a) noexcept {
  const double l = norm(a);
  return l > 0 ? (1 / l) * a : a;
}
inline bool is_finite(Vec3 a) noexcept { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }
/// Six times the signed volume of the tetrahedron a b c d (rounded; positive when d sees a b c counter-clockwise
/// reversed, i.e. det(b-a, c-a, d-a) > 0).
constexpr double volume6(Vec3 a, Vec3 b, Vec3 c, Vec3 d) noexcept { return dot(cross(b - a, c - a), d - a); }

}  // namespace skein
