// Lengths, volumes and quality in the metric, as the benchmark [UGAWG] of the Unstructured Grid Adaptation
// Working Group defines them (its measures are also the usual ones of the field).
#pragma once
#include <algorithm>
#include <cmath>

#include "base/ids.hpp"
#include "base/tensor.hpp"

namespace skein {

/// sqrt_det, changed by so little that it is of no account, but so that different metrics of the same determinant are
/// in an order: which of them an element takes must not hang on the order of its vertices.
inline double order_key_of(const SymTensor& m, double sqrt_det) noexcept {
  constexpr double kLittle = 1e-10;
  const double turned = m.xx + 0.618 * m.yy + 1.7 * m.xy + 2.3 * m.xz + 2.9 * m.yz;  // of no symmetry
  return sqrt_det * (1 + kLittle * turned / (m.xx + m.yy + m.zz));
}
/// ln sqrt(det M) from log M; exact for any anisotropy, where the determinant of a tensor that is turned against the
/// axes loses all digits from a ratio of about 10^4 on.
constexpr double log_sqrt_det(const SymTensor& log_m) noexcept { return 0.5 * (log_m.xx + log_m.yy + log_m.zz); }
inline VertMetric vert_metric(const SymTensor& m) noexcept {
  const double sqrt_det = std::sqrt(std::max(0.0, det(m)));
  return {m, sqrt_det, order_key_of(m, sqrt_det)};
}

/// Length of an edge from the lengths la, lb of its vector in the metrics of both ends: the logarithmic mean
/// (la - lb)/log(la/lb), by the series of 2 atanh(r), r = (la - lb)/(la + lb); relative error below 1e-4 up to a ratio
/// of 4, exact logarithm beyond.
inline double log_mean(double la, double lb) noexcept {
  const double s = la + lb;
  if (!(s > 0)) return 0;
  const double r = (la - lb) / s, r2 = r * r;
  if (r2 > 0.3) return la > 0 && lb > 0 ? (la - lb) / std::log(la / lb) : 0;
  return 0.5 * s / (1 + r2 * (1.0 / 3 + r2 * (1.0 / 5 + r2 * (1.0 / 7 + r2 * (1.0 / 9 + r2 * (1.0 / 11 + r2 / 13))))));
}
/// Length of the vector e between two vertices with metrics a and b (1 is ideal).
inline double edge_length(const SymTensor& a, const SymTensor& b, Vec3 e) noexcept {
  return log_mean(std::sqrt(quad(a, e)), std::sqrt(quad(b, e)));
}

/// What quality_cubed gives for quality q.
constexpr double cube(double q) noexcept { return q * q * q; }

/// Q^3 of the tetrahedron x0..x3 with vertex metrics m0..m3, Q the metric mean ratio
/// Q = 36/3^(1/3) (V sqrt(det M))^(2/3) / sum over edges of e'Me, M the vertex metric of largest determinant.
/// The cube needs no root; 1 for the unit tetrahedron, negative when it is inverted.
inline double quality_cubed(Vec3 x0, Vec3 x1, Vec3 x2, Vec3 x3, const VertMetric& m0, const VertMetric& m1,
                            const VertMetric& m2, const VertMetric& m3) noexcept {
  const VertMetric& p = m0.order_key >= m1.order_key ? m0 : m1;
  const VertMetric& q = m2.order_key >= m3.order_key ? m2 : m3;
  const VertMetric& m = p.order_key >= q.order_key ? p : q;
  const Vec3 a = x1 - x0, b = x2 - x0, c = x3 - x0;
  const double v = dot(cross(a, b), c) * (1.0 / 6) * m.sqrt_det;
  // The sum over the six edges of points 0, a, b, c is 4 (a'Ma + b'Mb + c'Mc) - (a+b+c)'M(a+b+c).
  const double s = 4 * (quad(m.m, a) + quad(m.m, b) + quad(m.m, c)) - quad(m.m, a + b + c);
  constexpr double kScale = 36.0 * 36.0 * 36.0 / 3.0;
  return kScale * v * std::abs(v) / (s * s * s);
}
/// The least Q^3 that any of the vertex metrics gives whose determinant is near the largest. Where a metric turns
/// within an element they differ much, and which determinant is the largest may hang on an error of interpolation.
inline double least_quality_cubed(Vec3 x0, Vec3 x1, Vec3 x2, Vec3 x3, const VertMetric& m0, const VertMetric& m1,
                                  const VertMetric& m2, const VertMetric& m3) noexcept {
  constexpr double kNear = 0.7;  ///< of sqrt(det): sizes that are wrong by a tenth in each direction
  const double most = std::max(std::max(m0.sqrt_det, m1.sqrt_det), std::max(m2.sqrt_det, m3.sqrt_det));
  double least = 1;
  for (const VertMetric* m : {&m0, &m1, &m2, &m3}) {
    if (m->sqrt_det >= kNear * most) least = std::min(least, quality_cubed(x0, x1, x2, x3, *m, *m, *m, *m));
  }
  return least;
}
/// What an element counts as where the sum over elements is to become less: 1/Q^6, so that the worst lead it. It grows
/// no more where elements are all but flat.
constexpr double inverse_sixth_power(double q3) noexcept {
  constexpr double kFlat = 1e-6;
  const double q = q3 > kFlat ? q3 : kFlat;
  return 1 / (q * q);
}
/// How far an edge is from unit length: below 0.1 for unit edges, above 1 for all others, and smooth in between, so
/// that the sum over some edges tells first of all how many are too long or too short.
inline double strain(double length) noexcept {
  const double u = 2 * std::log2(std::max(length, 1e-9)), u2 = u * u;
  return u2 <= 1 ? 0.1 * u2 * u2 : 0.9 + 0.1 * u2;
}
/// Q itself (0 for inverted or flat).
inline double quality(double cubed) noexcept { return cubed > 0 ? std::cbrt(cubed) : 0; }

}  // namespace skein
