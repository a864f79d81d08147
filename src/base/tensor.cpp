// Tensor algebra by Jacobi rotations.
#include "base/tensor.hpp"

#include <algorithm>

namespace skein {

Eigen eigen(const SymTensor& t) noexcept {
  double a[3][3] = {{t.xx, t.xy, t.xz}, {t.xy, t.yy, t.yz}, {t.xz, t.yz, t.zz}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    bool changed = false;
    for (const auto& pq : kPairs) {
      const int p = pq[0], q = pq[1];
      if (std::abs(a[p][q]) <= 1e-17 * std::sqrt(std::abs(a[p][p] * a[q][q])) || a[p][q] == 0) continue;
      changed = true;
      const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const double tan = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const double c = 1 / std::sqrt(tan * tan + 1), s = tan * c;
      const int r = 3 - p - q;
      const double apq = a[p][q], arp = a[r][p], arq = a[r][q];
      a[p][p] -= tan * apq;
      a[q][q] += tan * apq;
      a[p][q] = a[q][p] = 0;
      a[r][p] = a[p][r] = c * arp - s * arq;
      a[r][q] = a[q][r] = s * arp + c * arq;
      for (auto& row : v) {
        const double vp = row[p], vq = row[q];
        row[p] = c * vp - s * vq;
        row[q] = s * vp + c * vq;
      }
    }
    if (!changed) break;
  }
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int j) { return a[i][i] < a[j][j]; });
  Eigen e;
  for (std::size_t k = 0; k < 3; ++k) {
    const int o = order[k];
    e.value[k] = a[o][o];
    e.vector[k] = {v[0][o], v[1][o], v[2][o]};
  }
  return e;
}

SymTensor compose(const Eigen& e) noexcept {
  SymTensor m;
  for (std::size_t k = 0; k < 3; ++k) {
    const double l = e.value[k];
    const Vec3 v = e.vector[k];
    m = m + SymTensor{l * v.x * v.x, l * v.x * v.y, l * v.y * v.y, l * v.x * v.z, l * v.y * v.z, l * v.z * v.z};
  }
  return m;
}

SymTensor log(const SymTensor& m) noexcept {
  Eigen e = eigen(m);
  for (auto& l : e.value) l = std::log(l);
  return compose(e);
}

SymTensor exp(const SymTensor& m) noexcept {
  Eigen e = eigen(m);
  for (auto& l : e.value) l = std::exp(l);
  return compose(e);
}

bool is_positive_definite(const SymTensor& m) noexcept {
  if (!is_finite(m)) return false;
  const Eigen e = eigen(m);
  return e.value[0] > 0 && std::isfinite(e.value[2]);
}

namespace {
/// a^(p) for a positive definite tensor.
SymTensor power(const SymTensor& a, double p) noexcept {
  Eigen e = eigen(a);
  for (auto& l : e.value) l = std::pow(l, p);
  return compose(e);
}
}  // namespace

SymTensor congruence(const SymTensor& s, const SymTensor& m) noexcept {
  const Vec3 c0{s.xx, s.xy, s.xz}, c1{s.xy, s.yy, s.yz}, c2{s.xz, s.yz, s.zz};
  const Vec3 m0 = mul(m, c0), m1 = mul(m, c1), m2 = mul(m, c2);
  return {dot(c0, m0), dot(c0, m1), dot(c1, m1), dot(c0, m2), dot(c1, m2), dot(c2, m2)};
}

SymTensor intersect(const SymTensor& a, const SymTensor& b) noexcept {
  // In the frame where a is the identity, the common eigenvectors are those of b; take max(1, eigenvalue).
  const SymTensor half = power(a, 0.5);
  Eigen e = eigen(congruence(power(a, -0.5), b));
  for (auto& l : e.value) l = std::max(l, 1.0);
  return congruence(half, compose(e));
}

SymTensor clamp_sizes(const SymTensor& m, double h_min, double h_max) noexcept {
  Eigen e = eigen(m);
  for (auto& l : e.value) l = std::clamp(l, 1 / (h_max * h_max), 1 / (h_min * h_min));
  return compose(e);
}

}  // namespace skein
