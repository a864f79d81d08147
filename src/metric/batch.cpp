// Cyclic Jacobi rotations in lanes: as many for all, so without branches.
#include "metric/batch.hpp"

#include <cmath>

namespace skein {
namespace {

using Lanes = std::array<double, kTensorLanes>;

/// The matrix that is made diagonal, and the columns of the rotations so far, which become its eigenvectors.
struct Rotated {
  TensorLanes a;                            ///< by component: xx xy yy xz yz zz
  std::array<std::array<Lanes, 3>, 3> v{};  ///< v[p]: the p-th eigenvector
};

/// Makes a[pq] zero; pp, qq, rp, rq are the places of the other components that change.
template <std::size_t kP, std::size_t kQ, std::size_t kPP, std::size_t kQQ, std::size_t kPQ, std::size_t kRP,
          std::size_t kRQ>
void rotate(Rotated& m) noexcept {
  constexpr double kTiny = 1e-300;  // so that 0/0 is no angle
  Lanes c, s;
  for (std::size_t l = 0; l < kTensorLanes; ++l) {
    const double pq = m.a[kPQ][l], d = m.a[kQQ][l] - m.a[kPP][l];
    const double root = std::sqrt(d * d + 4 * pq * pq) + kTiny;
    const double tan = 2 * pq / (d >= 0 ? d + root : d - root);
    c[l] = 1 / std::sqrt(tan * tan + 1), s[l] = tan * c[l];
    m.a[kPP][l] -= tan * pq, m.a[kQQ][l] += tan * pq, m.a[kPQ][l] = 0;
    const double rp = m.a[kRP][l], rq = m.a[kRQ][l];
    m.a[kRP][l] = c[l] * rp - s[l] * rq, m.a[kRQ][l] = s[l] * rp + c[l] * rq;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t l = 0; l < kTensorLanes; ++l) {
      const double p = m.v[kP][k][l], q = m.v[kQ][k][l];
      m.v[kP][k][l] = c[l] * p - s[l] * q, m.v[kQ][k][l] = s[l] * p + c[l] * q;
    }
  }
}

/// Convergence is quadratic from the second or third sweep on; five take any matrix to rounding.
constexpr int kSweeps = 5;

}  // namespace

void vert_metrics_from_logs(const TensorLanes& log_m, std::array<VertMetric, kTensorLanes>& out) noexcept {
  Rotated m{log_m, {}};
  for (std::size_t k = 0; k < 3; ++k) m.v[k][k].fill(1);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    rotate<0, 1, 0, 2, 1, 3, 4>(m);
    rotate<0, 2, 0, 5, 3, 1, 4>(m);
    rotate<1, 2, 2, 5, 4, 1, 3>(m);
  }
  constexpr std::array<std::size_t, 3> kDiagonal{0, 2, 5};
  TensorLanes sum{};
  for (std::size_t k = 0; k < 3; ++k) {
    Lanes e;
    for (std::size_t l = 0; l < kTensorLanes; ++l) e[l] = std::exp(m.a[kDiagonal[k]][l]);
    const auto& v = m.v[k];
    for (std::size_t l = 0; l < kTensorLanes; ++l) {
      const double x = v[0][l], y = v[1][l], z = v[2][l], ex = e[l] * x, ey = e[l] * y, ez = e[l] * z;
      sum[0][l] += ex * x, sum[1][l] += ex * y, sum[2][l] += ey * y;
      sum[3][l] += ex * z, sum[4][l] += ey * z, sum[5][l] += ez * z;
    }
  }
  for (std::size_t l = 0; l < kTensorLanes; ++l) {
    out[l].m = {sum[0][l], sum[1][l], sum[2][l], sum[3][l], sum[4][l], sum[5][l]};
    out[l].sqrt_det = std::exp(0.5 * (log_m[0][l] + log_m[2][l] + log_m[5][l]));
    out[l].order_key = order_key_of(out[l].m, out[l].sqrt_det);
  }
}

}  // namespace skein
