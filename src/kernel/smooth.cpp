// Moving a vertex so that its elements get better.
#include "kernel/smooth.hpp"

#include <algorithm>

#include "mesh/predicates.hpp"

namespace skein {
namespace {

constexpr double kFlat = 1e-9;  ///< relative height up to which facets count as one plane, edges as one line

/// Solves the symmetric system h s = -g restricted to the directions of freedom; false if h is not positive there.
bool solve3(const SymTensor& h, Vec3 g, Vec3& s) noexcept {
  const double d = det(h);
  const double m2 = h.xx * h.yy - h.xy * h.xy;
  if (!(h.xx > 0) || !(m2 > 0) || !(d > 0)) return false;
  const Vec3 c0{h.xx, h.xy, h.xz}, c1{h.xy, h.yy, h.yz}, c2{h.xz, h.yz, h.zz};
  const Vec3 r{-g.x, -g.y, -g.z};
  s = {dot(r, cross(c1, c2)) / d, dot(c0, cross(r, c2)) / d, dot(c0, cross(c1, r)) / d};
  return true;
}

}  // namespace

bool Smoother::freedom(VertId v, Freedom& free) {
  const TetMesh& m = part_->mesh;
  free.dims = 3;
  if (m.has(v, kFrozen | kCorner | kRequired)) return false;
  if (!m.has(v, kSurface | kRidge)) return true;
  if (!part_->options.surface) return false;
  const bool ridge = m.has(v, kRidge);
  Vec3 normal, line;
  VertId ends[2] = {kNoVert, kNoVert};
  bool first = true;
  for (const TetId t : ball_) {
    for (int f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][static_cast<std::size_t>(f)];
      if (tag == 0 || m.tet2vert[t][static_cast<std::size_t>(f)] == v) continue;
      if ((tag & kRequiredFace) != 0) return false;
      const auto k = face_verts(m, make_face(t, f));
      if (ridge) {
        for (const VertId w : k) {
          if (w == v || !m.has(w, kRidge | kCorner) || m.features.find(v, w) == nullptr) continue;
          if (ends[0] == kNoVert || ends[0] == w) {
            ends[0] = w;
          } else if (ends[1] == kNoVert || ends[1] == w) {
            ends[1] = w;
          } else {
            return false;
          }
        }
        continue;
      }
      const Vec3 n = normalized(cross(part_->x(k[1]) - part_->x(k[0]), part_->x(k[2]) - part_->x(k[0])));
      if (first) normal = n;
      first = false;
      if (norm(cross(n, normal)) > kFlat * 1e3) return false;
    }
  }
  if (ridge) {
    if (ends[1] == kNoVert) return false;
    line = normalized(part_->x(ends[1]) - part_->x(ends[0]));
    if (norm(cross(line, part_->x(v) - part_->x(ends[0]))) > kFlat * norm(part_->x(ends[1]) - part_->x(ends[0]))) {
      return false;
    }
    free.dims = 1;
    free.t0 = line;
    return true;
  }
  free.dims = 2;
  const Vec3 axis = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  free.t0 = normalized(cross(normal, axis));
  free.t1 = cross(normal, free.t0);
  return true;
}

Vec3 Smoother::newton_step(VertId v, const Freedom& free) const noexcept {
  const TetMesh& m = part_->mesh;
  const Vec3 x = part_->x(v);
  const SymTensor& metric = part_->metric.at[v].m;
  Vec3 g;
  SymTensor h;
  for (const TetId t : ball_) {
    const auto k = face_verts(m, make_face(t, local_index(m.tet2vert[t], v)));
    const Vec3 a = part_->x(k[0]), b = part_->x(k[1]), c = part_->x(k[2]);
    const Vec3 ab = b - a, ac = c - a, xa = a - x, xb = b - x, xc = c - x;
    const Vec3 n = cross(ab, ac);
    const double vol = dot(n, xa);
    const Vec3 sum = xa + xb + xc;
    const double s = quad(metric, xa) + quad(metric, xb) + quad(metric, xc) + quad(metric, ab) + quad(metric, ac) +
                     quad(metric, c - b);
    if (!(vol > 0)) return {};
    // f = s^3/vol^2: log-derivatives of s (gradient -2 M sum, Hessian 6 M) and of vol (gradient -n).
    const double rv = 1 / vol, rs = 1 / s;
    const double f = s * s * s * rv * rv * part_->metric.at[v].sqrt_det;
    const Vec3 ds = (-2 * rs) * mul(metric, sum), dv = (-rv) * n;
    const Vec3 d = 3.0 * ds - 2.0 * dv;
    g += f * d;
    const auto outer = [](double w, Vec3 p) {
      return SymTensor{w * p.x * p.x, w * p.x * p.y, w * p.y * p.y, w * p.x * p.z, w * p.y * p.z, w * p.z * p.z};
    };
    h = h + f * (outer(1, d) + outer(-3, ds) + outer(2, dv) + (18 * rs) * metric);
  }
  if (free.dims == 1) {
    const double hh = dot(free.t0, mul(h, free.t0));
    return hh > 0 ? (-dot(g, free.t0) / hh) * free.t0 : Vec3{};
  }
  if (free.dims == 2) {
    const double h00 = dot(free.t0, mul(h, free.t0)), h01 = dot(free.t0, mul(h, free.t1)),
                 h11 = dot(free.t1, mul(h, free.t1));
    const double g0 = dot(g, free.t0), g1 = dot(g, free.t1), d = h00 * h11 - h01 * h01;
    if (!(h00 > 0) || !(d > 0)) return {};
    return (-(h11 * g0 - h01 * g1) / d) * free.t0 + (-(h00 * g1 - h01 * g0) / d) * free.t1;
  }
  Vec3 s;
  return solve3(h, g, s) ? s : Vec3{};
}

bool Smoother::interpolate(VertId v, Vec3 x, SymTensor& log_m) const noexcept {
  const TetMesh& m = part_->mesh;
  double best = -1e300;
  std::array<double, 4> weight{};
  TetId in = kNoTet;
  for (const TetId t : ball_) {
    const auto& tv = m.tet2vert[t];
    const Vec3 p[4] = {part_->x(tv[0]), part_->x(tv[1]), part_->x(tv[2]), part_->x(tv[3])};
    const double whole = volume6(p[0], p[1], p[2], p[3]);
    const std::array<double, 4> w{volume6(x, p[1], p[2], p[3]) / whole, volume6(p[0], x, p[2], p[3]) / whole,
                                  volume6(p[0], p[1], x, p[3]) / whole, volume6(p[0], p[1], p[2], x) / whole};
    const double low = std::min({w[0], w[1], w[2], w[3]});
    if (low > best) {
      best = low;
      weight = w;
      in = t;
      if (low >= 0) break;
    }
  }
  if (in == kNoTet || best < -0.1) return false;
  double total = 0;
  for (auto& w : weight) total += w = std::max(w, 0.0);
  log_m = {};
  for (std::size_t i = 0; i < 4; ++i) {
    log_m = log_m + (weight[i] / total) * part_->metric.log_at[m.tet2vert[in][i]];
  }
  (void)v;
  return true;
}

bool Smoother::attempt(VertId v, Vec3 x, double old_sum, double old_min) {
  Part& p = *part_;
  const Vec3 was = p.x(v);
  const VertMetric was_metric = p.metric.at[v];
  const SymTensor was_log = p.metric.log_at[v];
  SymTensor log_m;
  if (!interpolate(v, x, log_m)) return false;
  p.mesh.coords[v] = x;
  p.metric.set_log(v, log_m);
  double sum = 0, low = 1;
  fresh_.clear();
  for (const TetId t : ball_) {
    const double q = quality_cubed(p, t);
    const auto& tv = p.mesh.tet2vert[t];
    if (!(q > 0) || orient3d_sign(p.x(tv[0]), p.x(tv[1]), p.x(tv[2]), p.x(tv[3])) <= 0) {
      low = -1;
      break;
    }
    fresh_.push_back(q);
    sum += 1 / q;
    low = std::min(low, q);
  }
  constexpr double kGood = 0.5 * 0.5 * 0.5;
  if (low > 0 && sum < 0.995 * old_sum && low >= std::min(old_min, kGood)) {
    for (std::size_t i = 0; i < ball_.size(); ++i) {
      p.q3[ball_[i]] = static_cast<float>(fresh_[i]);
      p.dirty[ball_[i]] = kAllPasses;
    }
    return true;
  }
  p.mesh.coords[v] = was;
  p.metric.at[v] = was_metric;
  p.metric.log_at[v] = was_log;
  return false;
}

bool Smoother::move(VertId v) {
  Part& p = *part_;
  if (p.mesh.has(v, kFrozen | kCorner | kRequired)) return false;
  ball_.clear();
  if (!gather_ball(p, v, ball_, 500)) return false;
  Freedom free;
  if (!freedom(v, free)) return false;
  double sum = 0, low = 1;
  for (const TetId t : ball_) {
    const double q = p.q3[t];
    sum += 1 / std::max(q, 1e-30);
    low = std::min(low, q);
  }
  Vec3 step = newton_step(v, free);
  if (!is_finite(step) || quad(p.metric.at[v].m, step) < 1e-4) return false;
  // The step may not jump out of the ball: at most the size of an element.
  const double length = std::sqrt(quad(p.metric.at[v].m, step));
  if (length > 0.5) step = (0.5 / length) * step;
  for (int i = 0; i < 3; ++i) {
    if (attempt(v, p.x(v) + step, sum, low)) {
      ++p.counts.smooth;
      return true;
    }
    step = 0.4 * step;
  }
  return false;
}

}  // namespace skein
