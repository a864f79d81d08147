// Measuring many tetrahedra with a common apex. The inner loops run over the lanes of a block and have no branches.
#include "kernel/cone.hpp"

#include <algorithm>

#include "base/loops.hpp"

namespace skein {
namespace {

/// 6 * 8.0e-16 as in orient3d_sign: relative to the product of the largest coordinate differences.
constexpr double kOrientBound = 6 * 8.0e-16;

}  // namespace

void Cone::grow() {
  blocks_.emplace_back();
  q3_.emplace_back();
  room_ += kLanes;
}

double Cone::judge(Vec3 x, const VertMetric& m) {
  Lanes low;
  low.fill(1);
  constexpr double kScale = 36.0 * 36.0 * 36.0 / 3.0;
  for (std::size_t k = 0; k < block_count(); ++k) {
    const Block& f = blocks_[k];
    Lanes& q3 = q3_[k];
    SKEIN_INDEPENDENT_LOOP
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Vec3 a = f.minus(kA, l, x);
      const Vec3 b = f.minus(kB, l, x);
      const Vec3 c = f.minus(kC, l, x);
      const double det = dot(cross(a, b), c);
      const double mx = std::max(std::max(std::abs(a.x), std::abs(b.x)), std::abs(c.x));
      const double my = std::max(std::max(std::abs(a.y), std::abs(b.y)), std::abs(c.y));
      const double mz = std::max(std::max(std::abs(a.z), std::abs(b.z)), std::abs(c.z));
      const bool face = f.row[kOrderKey][l] > m.order_key;
      const SymTensor t{face ? f.row[kMetric][l] : m.m.xx,     face ? f.row[kMetric + 1][l] : m.m.xy,
                        face ? f.row[kMetric + 2][l] : m.m.yy, face ? f.row[kMetric + 3][l] : m.m.xz,
                        face ? f.row[kMetric + 4][l] : m.m.yz, face ? f.row[kMetric + 5][l] : m.m.zz};
      const double v = det * (1.0 / 6) * (face ? f.row[kSqrtDet][l] : m.sqrt_det);
      const double s = 4 * (quad(t, a) + quad(t, b) + quad(t, c)) - quad(t, a + b + c);
      const double q = kScale * v * v / (s * s * s);
      q3[l] = det > kOrientBound * (mx * my * mz) ? q : 0.0;
      low[l] = std::min(low[l], q3[l]);
    }
  }
  return *std::min_element(low.begin(), low.end());
}

double Cone::sum_of_inverses() const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < size_; ++i) sum += 1 / q3(i);
  return sum;
}

Cone::Newton Cone::newton(Vec3 x, const SymTensor& m) {
  // With s the sum of the squared edge lengths and v the volume, F = s^3/v^2. Log-derivatives: of s the gradient is
  // -2 M (xa + xb + xc)/s and the Hessian 6 M/s, of v the gradient is minus the face's normal.
  std::array<Lanes, 12> sum{};
  Lanes lowest;
  lowest.fill(1);
  for (std::size_t k = 0; k < block_count(); ++k) {
    const Block& f = blocks_[k];
    const std::size_t used = std::min(kLanes, size_ - k * kLanes);
    SKEIN_INDEPENDENT_LOOP
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Vec3 a = f.minus(kA, l, x);
      const Vec3 b = f.minus(kB, l, x);
      const Vec3 c = f.minus(kC, l, x);
      const Vec3 ab = cross(a, b), n = cross(b, c) + cross(c, a) + ab;
      const double v = dot(ab, c);
      const Vec3 w = a + b + c, mw = mul(m, w);
      const double s = 4 * (quad(m, a) + quad(m, b) + quad(m, c)) - dot(w, mw);
      const double rv = 1 / v, rs = 1 / s;
      const double value = l < used ? s * s * s * rv * rv : 0.0;
      const Vec3 ds = (-2 * rs) * mw, dv = (-rv) * n, d = 3.0 * ds - 2.0 * dv;
      lowest[l] = std::min(lowest[l], v);
      sum[0][l] += value;
      sum[1][l] += value * d.x;
      sum[2][l] += value * d.y;
      sum[3][l] += value * d.z;
      sum[4][l] += value * (d.x * d.x - 3 * ds.x * ds.x + 2 * dv.x * dv.x);
      sum[5][l] += value * (d.x * d.y - 3 * ds.x * ds.y + 2 * dv.x * dv.y);
      sum[6][l] += value * (d.y * d.y - 3 * ds.y * ds.y + 2 * dv.y * dv.y);
      sum[7][l] += value * (d.x * d.z - 3 * ds.x * ds.z + 2 * dv.x * dv.z);
      sum[8][l] += value * (d.y * d.z - 3 * ds.y * ds.z + 2 * dv.y * dv.z);
      sum[9][l] += value * (d.z * d.z - 3 * ds.z * ds.z + 2 * dv.z * dv.z);
      sum[10][l] += value * rs;
    }
  }
  std::array<double, 11> t{};
  for (std::size_t i = 0; i < t.size(); ++i) {
    for (const double v : sum[i]) t[i] += v;
  }
  Newton out;
  out.value = t[0];
  out.gradient = {t[1], t[2], t[3]};
  out.hessian = SymTensor{t[4], t[5], t[6], t[7], t[8], t[9]} + (18 * t[10]) * m;
  out.valid = *std::min_element(lowest.begin(), lowest.end()) > 0;
  return out;
}

Cone::Place Cone::locate(Vec3 x, Vec3 step) {
  Place best;
  double highest = -1e300;
  for (std::size_t k = 0; k < block_count(); ++k) {
    const Block& f = blocks_[k];
    std::array<Lanes, 3> w;
    Lanes low;
    SKEIN_INDEPENDENT_LOOP
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Vec3 a = f.minus(kA, l, x);
      const Vec3 b = f.minus(kB, l, x);
      const Vec3 c = f.minus(kC, l, x);
      const Vec3 bc = cross(b, c);
      const double r = 1 / dot(a, bc);
      w[0][l] = r * dot(step, bc);
      w[1][l] = r * dot(step, cross(c, a));
      w[2][l] = r * dot(step, cross(a, b));
      low[l] = std::min(std::min(w[0][l], w[1][l]), w[2][l]);
    }
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (low[l] <= highest) continue;
      highest = low[l];
      best = {std::min(k * kLanes + l, size_ - 1), {w[0][l], w[1][l], w[2][l]}};
    }
  }
  return best;
}

void Spheres::grow() {
  blocks_.emplace_back();
  room_ += kLanes;
}

void Spheres::test(Vec3 x, const SymTensor& m) {
  // What the lanes beyond the last tetrahedron hold is of an earlier test, and nobody reads the result.
  for (std::size_t k = 0; k * kLanes < size_; ++k) {
    Block& s = blocks_[k];
    const auto& [pa, pb, pc, pd] = s.x;
    SKEIN_INDEPENDENT_LOOP
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Vec3 a{pa[0][l] - x.x, pa[1][l] - x.y, pa[2][l] - x.z};
      const Vec3 b{pb[0][l] - x.x, pb[1][l] - x.y, pb[2][l] - x.z};
      const Vec3 c{pc[0][l] - x.x, pc[1][l] - x.y, pc[2][l] - x.z};
      const Vec3 d{pd[0][l] - x.x, pd[1][l] - x.y, pd[2][l] - x.z};
      const Vec3 cd = cross(c, d), ab = cross(a, b);
      s.inside[l] =
          quad(m, a) * dot(b, cd) - quad(m, b) * dot(a, cd) + quad(m, c) * dot(ab, d) - quad(m, d) * dot(ab, c);
    }
  }
}

}  // namespace skein
