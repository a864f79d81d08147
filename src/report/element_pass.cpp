// Eight tetrahedra at a time, in lanes: gathered first, then judged without branches.
#include "report/element_pass.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "metric/complexity.hpp"

namespace skein {
namespace {

constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;
using VecLanes = std::array<Lanes, 3>;

/// The cosines of 10, 20 .. 170 degrees: comparing with them is cheaper than an arc cosine for each angle.
const std::array<double, 17> angle_bounds = [] {
  std::array<double, 17> bounds;
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    bounds[i] = std::cos(std::numbers::pi / 18 * static_cast<double>(i + 1));
  }
  return bounds;
}();

struct Batch {
  std::array<VecLanes, 4> x;
  std::array<Lanes, 6> metric;  ///< the one of largest determinant
  Lanes sqrt_det, mean_sqrt_det;
};

/// Volume, angles and, with metrics, quality of the lanes of a batch.
class Judge {
 public:
  explicit Judge(bool with_metric) : with_metric_(with_metric) {}

  /// Of the first n lanes; the others hold a tetrahedron that has been counted.
  void look_at(const Batch& b, std::size_t n, double* quality) noexcept {
    find_volumes(b, n);
    find_angles(b, n);
    if (with_metric_) find_quality(b, n, quality);
  }
  [[nodiscard]] TetSums sums() const noexcept {
    TetSums s = sums_;
    for (std::size_t i = 0; i < kLanes; ++i) {
      s.max_cos = std::max(s.max_cos, max_cos_[i]), s.min_cos = std::min(s.min_cos, min_cos_[i]);
    }
    // above_[k] is the number of angles of 10 (k+1) degrees or more.
    s.angles[0] = all_angles_ - above_[0];
    for (std::size_t k = 1; k < 17; ++k) s.angles[k] = above_[k - 1] - above_[k];
    s.angles[17] = above_[16];
    return s;
  }

 private:
  void find_volumes(const Batch& b, std::size_t n) noexcept {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const auto edge = [&](std::size_t k) {
        return Vec3{b.x[k][0][l] - b.x[0][0][l], b.x[k][1][l] - b.x[0][1][l], b.x[k][2][l] - b.x[0][2][l]};
      };
      volume_[l] = dot(cross(edge(1), edge(2)), edge(3)) / 6;
    }
    for (std::size_t l = 0; l < n; ++l) {
      sums_.volume += volume_[l];
      sums_.min_volume = std::min(sums_.min_volume, volume_[l]);
      sums_.nonpositive += volume_[l] > 0 ? 0 : 1;
    }
  }

  void find_angles(const Batch& b, std::size_t n) noexcept {
    std::array<VecLanes, 4> normal;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& k = kFaceVerts[f];
      const VecLanes &p = b.x[k[0]], &q = b.x[k[1]], &r = b.x[k[2]];
      for (std::size_t l = 0; l < kLanes; ++l) {
        const Vec3 c = cross({q[0][l] - p[0][l], q[1][l] - p[1][l], q[2][l] - p[2][l]},
                             {r[0][l] - p[0][l], r[1][l] - p[1][l], r[2][l] - p[2][l]});
        const double length = std::sqrt(dot(c, c)), scale = length > 0 ? 1 / length : 0;
        normal[f][0][l] = scale * c.x, normal[f][1][l] = scale * c.y, normal[f][2][l] = scale * c.z;
      }
    }
    for (const auto& e : kEdgeVerts) {
      const VecLanes &p = normal[e[0]], &q = normal[e[1]];
      Lanes c;
      for (std::size_t l = 0; l < kLanes; ++l) {
        const double exact = -(p[0][l] * q[0][l] + p[1][l] * q[1][l] + p[2][l] * q[2][l]);
        c[l] = std::min(std::max(exact, -1.0), 1.0);
        max_cos_[l] = std::max(max_cos_[l], c[l]), min_cos_[l] = std::min(min_cos_[l], c[l]);
      }
      for (std::size_t k = 0; k < 17; ++k) {
        std::int64_t above = 0;
        for (std::size_t l = 0; l < n; ++l) above += c[l] <= angle_bounds[k] ? 1 : 0;
        above_[k] += above;
      }
    }
    all_angles_ += 6 * static_cast<std::int64_t>(n);
  }

  /// As quality_cubed() does it.
  void find_quality(const Batch& b, std::size_t n, double* quality) noexcept {
    constexpr double kScale = 36.0 * 36.0 * 36.0 / 3.0;
    Lanes q3;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const SymTensor m{b.metric[0][l], b.metric[1][l], b.metric[2][l], b.metric[3][l], b.metric[4][l], b.metric[5][l]};
      const Vec3 x0{b.x[0][0][l], b.x[0][1][l], b.x[0][2][l]};
      const Vec3 e1 = Vec3{b.x[1][0][l], b.x[1][1][l], b.x[1][2][l]} - x0;
      const Vec3 e2 = Vec3{b.x[2][0][l], b.x[2][1][l], b.x[2][2][l]} - x0;
      const Vec3 e3 = Vec3{b.x[3][0][l], b.x[3][1][l], b.x[3][2][l]} - x0;
      const double v = volume_[l] * b.sqrt_det[l];
      const double s = 4 * (quad(m, e1) + quad(m, e2) + quad(m, e3)) - quad(m, e1 + e2 + e3);
      q3[l] = kScale * v * std::abs(v) / (s * s * s);
    }
    for (std::size_t l = 0; l < n; ++l) {
      sums_.complexity += b.mean_sqrt_det[l] * std::abs(volume_[l]);
      quality[l] = skein::quality(q3[l]);
    }
  }

  bool with_metric_;
  TetSums sums_;
  Lanes volume_;
  Lanes max_cos_ = filled(-1), min_cos_ = filled(1);
  std::array<std::int64_t, 17> above_{};
  std::int64_t all_angles_ = 0;

  static constexpr Lanes filled(double v) noexcept {
    Lanes l{};
    l.fill(v);
    return l;
  }
};

void gather(const TetMesh& m, const IdVector<VertId, VertMetric>* metric, TetId t, std::size_t l, Batch& b) noexcept {
  const auto& v = m.tet2vert[t];
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 x = m.coords[v[k]];
    b.x[k][0][l] = x.x, b.x[k][1][l] = x.y, b.x[k][2][l] = x.z;
  }
  if (metric == nullptr) return;
  const VertMetric* strictest = &(*metric)[v[0]];
  constexpr double kLeast = 1e-300;
  AtVerts log_sqrt_det{std::log(std::max(strictest->sqrt_det, kLeast))};
  for (std::size_t k = 1; k < 4; ++k) {
    const VertMetric& a = (*metric)[v[k]];
    log_sqrt_det[k] = std::log(std::max(a.sqrt_det, kLeast));
    if (a.order_key > strictest->order_key) strictest = &a;
  }
  const SymTensor& s = strictest->m;
  b.metric[0][l] = s.xx, b.metric[1][l] = s.xy, b.metric[2][l] = s.yy;
  b.metric[3][l] = s.xz, b.metric[4][l] = s.yz, b.metric[5][l] = s.zz;
  b.sqrt_det[l] = strictest->sqrt_det, b.mean_sqrt_det[l] = mean_of_log_linear(log_sqrt_det);
}

}  // namespace

TetSums& TetSums::operator+=(const TetSums& s) noexcept {
  nonpositive += s.nonpositive, volume += s.volume, complexity += s.complexity;
  min_volume = std::min(min_volume, s.min_volume);
  max_cos = std::max(max_cos, s.max_cos), min_cos = std::min(min_cos, s.min_cos);
  for (std::size_t i = 0; i < angles.size(); ++i) angles[i] += s.angles[i];
  return *this;
}

TetSums element_pass(const TetMesh& m, const IdVector<VertId, VertMetric>* metric, std::size_t first, std::size_t last,
                     std::span<double> quality) {
  Judge judge(metric != nullptr);
  Batch b{};
  for (std::size_t i = first; i < last; i += kLanes) {
    const std::size_t n = std::min(kLanes, last - i);
    for (std::size_t l = 0; l < kLanes; ++l) gather(m, metric, to_id<TetId>(i + std::min(l, n - 1)), l, b);
    judge.look_at(b, n, metric == nullptr ? nullptr : quality.data() + i);
  }
  return judge.sums();
}

}  // namespace skein
