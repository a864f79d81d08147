// Symmetric 3x3 tensors and their algebra: the metric M of the mesh, its logarithm, intersection.
#pragma once
#include <array>
#include <cmath>

#include "base/vec3.hpp"

namespace skein {

/// Symmetric 3x3 tensor in Medit order (m11 m12 m22 m13 m23 m33). As a metric its unit is 1/length^2.
struct SymTensor {
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;
  friend constexpr SymTensor operator+(const SymTensor& a, const SymTensor& b) noexcept {
    return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy, a.xz + b.xz, a.yz + b.yz, a.zz + b.zz};
  }
  friend constexpr SymTensor operator*(double s, const SymTensor& a) noexcept {
    return {s * a.xx, s * a.xy, s * a.yy, s * a.xz, s * a.yz, s * a.zz};
  }
  friend constexpr bool operator==(const SymTensor&, const SymTensor&) = default;
};

/// The metric at a vertex with the square root of its determinant beside it.
struct alignas(64) VertMetric {
  SymTensor m;           ///< 1/length^2
  double sqrt_det = 1;   ///< 1/length^3
  double order_key = 1;  ///< who has the largest determinant is told by this; see order_key_of (metric/measure.hpp)
};

constexpr SymTensor isotropic(double diagonal) noexcept { return {diagonal, 0, diagonal, 0, 0, diagonal}; }
/// e' M e
constexpr double quad(const SymTensor& m, Vec3 e) noexcept {
  return m.xx * e.x * e.x + m.yy * e.y * e.y + m.zz * e.z * e.z +
         2 * (m.xy * e.x * e.y + m.xz * e.x * e.z + m.yz * e.y * e.z);
}
constexpr Vec3 mul(const SymTensor& m, Vec3 e) noexcept {
  return {m.xx * e.x + m.xy * e.y + m.xz * e.z, m.xy * e.x + m.yy * e.y + m.yz * e.z,
          m.xz * e.x + m.yz * e.y + m.zz * e.z};
}
constexpr double det(const SymTensor& m) noexcept {
  return m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
}
inline bool is_finite(const SymTensor& m) noexcept { return std::isfinite(m.xx + m.xy + m.yy + m.xz + m.yz + m.zz); }

/// Eigenvalues (ascending) and orthonormal eigenvectors: m = sum value[i] vector[i] vector[i]'.
struct Eigen {
  std::array<double, 3> value;
  std::array<Vec3, 3> vector;
};
/// Cyclic Jacobi rotations; accurate also for strongly anisotropic tensors. @pre m is finite.
Eigen eigen(const SymTensor& m) noexcept;
SymTensor compose(const Eigen& e) noexcept;

/// Matrix logarithm. @pre m is positive definite.
SymTensor log(const SymTensor& m) noexcept;
/// Matrix exponential of a symmetric tensor (the inverse of log).
SymTensor exp(const SymTensor& m) noexcept;
/// True when all eigenvalues are finite and greater than zero.
bool is_positive_definite(const SymTensor& m) noexcept;
/// The metric whose unit ball lies in both unit balls (simultaneous reduction), the strictest of both.
SymTensor intersect(const SymTensor& a, const SymTensor& b) noexcept;
/// s m s
SymTensor congruence(const SymTensor& s, const SymTensor& m) noexcept;
/// The eigenvalues clamped to [1/h_max^2, 1/h_min^2].
SymTensor clamp_sizes(const SymTensor& m, double h_min, double h_max) noexcept;

}  // namespace skein
