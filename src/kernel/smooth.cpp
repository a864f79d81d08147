// Moving a vertex so that its elements get better.
#include "kernel/smooth.hpp"

#include <algorithm>
#include <numeric>

namespace skein {
namespace {

constexpr double kFlat = 1e-9;  ///< relative height up to which facets count as one plane, edges as one line
constexpr std::size_t kMaxBall = 500;
constexpr double kSmallestGain = 0.004;  ///< relative decrease of the sum that Newton's model must promise

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

/// The same in the plane or along the line of freedom, too; zero where h is not positive.
Vec3 minimum(const SymTensor& h, Vec3 g, int dims, Vec3 t0, Vec3 t1) noexcept {
  Vec3 step;
  if (dims == 1) {
    const double hh = dot(t0, mul(h, t0));
    return hh > 0 ? (-dot(g, t0) / hh) * t0 : step;
  }
  if (dims == 2) {
    const double h00 = dot(t0, mul(h, t0)), h01 = dot(t0, mul(h, t1)), h11 = dot(t1, mul(h, t1));
    const double g0 = dot(g, t0), g1 = dot(g, t1), d = h00 * h11 - h01 * h01;
    if (!(h00 > 0) || !(d > 0)) return step;
    return (-(h11 * g0 - h01 * g1) / d) * t0 + (-(h00 * g1 - h01 * g0) / d) * t1;
  }
  return solve3(h, g, step) ? step : Vec3{};
}

}  // namespace

bool Smoother::freedom(VertId v, Freedom& free) {
  const TetMesh& m = part_->mesh;
  free.dims = 3;
  if (m.has(v, kFrozen) || m.has(v, kCorner | kRequired)) return false;
  if (!m.has(v, kSurface | kRidge)) return true;
  if (!part_->options.surface) return false;
  const bool ridge = m.has(v, kRidge);
  Vec3 one, normal, line;  // of one facet, of all by their areas: what a needle says is next to nothing
  VertId ends[2] = {kNoVert, kNoVert};
  bool first = true;
  for (const FaceId at : ball_) {
    const TetId t = face_tet(at);
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f];
      if (tag == 0 || f == face_side(at)) continue;
      if ((tag & kRequiredFace) != 0) return false;
      const auto k = m.verts(make_face(t, f));
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
      const Vec3 area = cross(part_->x(k[1]) - part_->x(k[0]), part_->x(k[2]) - part_->x(k[0]));
      const Vec3 n = normalized(area);
      if (first) one = n;
      first = false;
      if (norm(cross(n, one)) > kFlat * 1e3) return false;
      // Of an internal interface, facets come from both sides.
      normal += dot(n, one) < 0 ? -1.0 * area : area;
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
  normal = normalized(normal);
  const Vec3 axis = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  free.t0 = normalized(cross(normal, axis));
  free.t1 = cross(normal, free.t0);
  return true;
}

Vec3 Smoother::newton_step(VertId v, const Freedom& free, double& gain) {
  gain = 0;
  const Cone::Newton n = cone_.newton(part_->x(v), part_->mesh.metric[v].m);
  if (!n.valid) return {};
  const Vec3 step = minimum(n.hessian, n.gradient, free.dims, free.t0, free.t1);
  gain = -0.5 * dot(n.gradient, step) / n.value;
  return step;
}

Vec3 Smoother::spring_step(VertId v, const Freedom& free) const {
  const TetMesh& m = part_->mesh;
  const Vec3 x = part_->x(v);
  Vec3 sum;
  double count = 0;
  for (const FaceId at : ball_) {
    for (const VertId w : m.tet2vert[face_tet(at)]) {  // a neighbour counts once for each tetrahedron round its edge
      if (w == v) continue;
      sum += (1 - 1 / std::max(part_->length(v, w), 0.1)) * (part_->x(w) - x);
      count += 1;
    }
  }
  const Vec3 step = (1 / count) * sum;
  if (free.dims == 3) return step;
  const Vec3 along = dot(step, free.t0) * free.t0;
  return free.dims == 1 ? along : along + dot(step, free.t1) * free.t1;
}

bool Smoother::interpolate_from_anchor(VertId v, Vec3 x, SymTensor& log_m) {
  const auto& [from, log_from] = part_->mesh.anchor[v];
  const Cone::Place place = cone_.locate(from, x - from);
  const auto k = part_->mesh.verts(ball_[place.face]);
  const auto& w = place.weight;
  const double rest = 1 - w[0] - w[1] - w[2];
  constexpr double kRounding = -1e-6;
  if (!(w[0] > kRounding) || !(w[1] > kRounding) || !(w[2] > kRounding) || !(rest > kRounding)) return false;
  if (!(volume6(from, part_->x(k[0]), part_->x(k[1]), part_->x(k[2])) > 0)) return false;
  log_m = rest * log_from;
  for (std::size_t i = 0; i < 3; ++i) log_m = log_m + w[i] * part_->mesh.log_metric[k[i]];
  return true;
}

bool Smoother::interpolate(VertId v, Vec3 step, SymTensor& log_m) {
  if (!part_->mesh.anchor.empty() && interpolate_from_anchor(v, part_->x(v) + step, log_m)) return true;
  const Cone::Place place = cone_.locate(part_->x(v), step);
  const auto k = part_->mesh.verts(ball_[place.face]);
  double rest = 1;
  log_m = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const double w = std::max(place.weight[i], 0.0);
    rest -= w;
    log_m = log_m + w * part_->mesh.log_metric[k[i]];
  }
  if (rest < -0.1) return false;  // beyond the ball
  log_m = (1 / (1 - std::min(rest, 0.0))) * (log_m + std::max(rest, 0.0) * part_->mesh.log_metric[v]);
  return true;
}

std::size_t Smoother::list_link(VertId v) {
  Part& p = *part_;
  if (link_.size() < 4 * ball_.size()) link_.resize(4 * ball_.size());
  const std::uint32_t stamp = ++p.vert_stamp;
  p.vert_mark[v] = stamp;
  std::size_t n = 0;
  for (const FaceId f : ball_) {
    for (const VertId w : p.mesh.tet2vert[face_tet(f)]) {
      link_[n] = w;
      n += p.vert_mark[w] != stamp ? 1 : 0;
      p.vert_mark[w] = stamp;
    }
  }
  return n;
}

void Smoother::mark_changed(VertId v) {
  Part& p = *part_;
  const std::size_t n = list_link(v);
  p.edge_class[v] = 0;
  unsigned any = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t bits = p.classify(v, link_[i]);
    p.edge_class[link_[i]] = bits;
    any |= bits;
  }
  for (std::size_t i = 0; i < ball_.size(); ++i) {
    const TetId t = face_tet(ball_[i]);
    p.q3[t] = static_cast<float>(cone_.q3(i));
    p.dirty[t] = kAnew;
    const auto& tv = p.mesh.tet2vert[t];
    const auto& edge_of = kEdgeOf[face_side(ball_[i])];
    EdgeBits edges = p.edges[t];
    edges.keep(~(1U << edge_of[0] | 1U << edge_of[1] | 1U << edge_of[2] | 1U << edge_of[3]));
    for (std::size_t k = 0; any != 0 && k < 4; ++k) edges.add(edge_of[k], p.edge_class[tv[k]]);
    p.edges[t] = edges;
  }
}

double Smoother::judge(Vec3 x, const VertMetric& m, double bound) {
  double low = cone_.judge(x, m);
  if (!part_->careful || !(low > 0) || low < bound) return low;
  for (std::size_t i = 0; i < ball_.size() && low >= bound; ++i) {
    const auto k = part_->mesh.verts(ball_[i]);
    const auto& y = part_->mesh.coords;
    const auto& n = part_->mesh.metric;
    const double q = least_quality_cubed(x, y[k[0]], y[k[1]], y[k[2]], m, n[k[0]], n[k[1]], n[k[2]]);
    cone_.set_q3(i, q);
    low = std::min(low, q);
  }
  return low;
}

void Smoother::place(VertId v, Vec3 x, const VertMetric& m, const SymTensor& log_m) {
  part_->mesh.coords[v] = x;
  part_->mesh.metric[v] = m;
  part_->mesh.log_metric[v] = log_m;
  mark_changed(v);
  ++part_->counts.smooth;
}

bool Smoother::attempt(VertId v, Vec3 step, double old_sum, double old_min) {
  Part& p = *part_;
  SymTensor log_m;
  if (!interpolate(v, step, log_m)) return false;
  const Vec3 x = p.x(v) + step;
  const VertMetric m = vert_metric_from_log(log_m);
  constexpr double kGood = 0.5 * 0.5 * 0.5;
  const double bound = std::min(old_min, kGood), low = judge(x, m, bound);
  if (!(low > 0) || low < bound || cone_.sum_of_inverses() >= 0.995 * old_sum) return false;
  place(v, x, m, log_m);
  return true;
}

void Smoother::index_balls() {
  const TetMesh& m = part_->mesh;
  first_.assign(m.vert_slots() + 1, 0);
  for (const auto& tv : m.tet2vert) {
    if (tv[0] == kNoVert) continue;
    for (const VertId v : tv) ++first_[idx(v) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  balls_.resize(static_cast<std::size_t>(first_.back()));
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      balls_[static_cast<std::size_t>(first_[idx(m.tet2vert[t][k])]++)] = make_face(t, k);
    }
  }
  // Every start has moved to the next one's.
  std::move_backward(first_.begin(), first_.end() - 1, first_.end());
  first_.front() = 0;
}

void Smoother::drop_index() noexcept { first_.clear(); }

void Smoother::fetch_ball(VertId v) const noexcept {
  for (const FaceId f : indexed_ball(v)) {
    __builtin_prefetch(&part_->mesh.tet2vert[face_tet(f)]);
    __builtin_prefetch(&part_->q3[face_tet(f)]);
  }
}

void Smoother::fetch_vertices(VertId v) const noexcept {
  for (const FaceId f : indexed_ball(v)) {
    for (const VertId w : part_->mesh.tet2vert[face_tet(f)]) {
      __builtin_prefetch(&part_->mesh.coords[w]);
      __builtin_prefetch(&part_->mesh.metric[w].sqrt_det);
    }
  }
}

std::span<const FaceId> Smoother::indexed_ball(VertId v) const noexcept {
  if (first_.empty()) return {};
  const auto begin = first_[idx(v)], end = first_[idx(v) + 1];
  return {balls_.data() + begin, static_cast<std::size_t>(end - begin)};
}

bool Smoother::find_ball(VertId v) {
  ball_.clear();
  if (first_.empty()) {
    tets_.clear();
    if (!gather_ball(*part_, v, tets_, kMaxBall)) return false;
    for (const TetId t : tets_) ball_.push_back(make_face(t, local_index(part_->mesh.tet2vert[t], v)));
    return true;
  }
  const auto ball = indexed_ball(v);
  if (ball.size() > kMaxBall) return false;
  ball_.assign(ball.begin(), ball.end());
  return true;
}

bool Smoother::gather(VertId v, Ball& ball) {
  Part& p = *part_;
  if (p.mesh.has(v, kFrozen) || p.mesh.has(v, kCorner | kRequired) || !find_ball(v) || !freedom(v, ball.free))
    return false;
  cone_.clear();
  for (const FaceId f : ball_) {
    const auto k = p.mesh.verts(f);
    cone_.add(p, k[0], k[1], k[2]);
    const double q = p.q3[face_tet(f)];
    ball.sum += 1 / std::max(q, 1e-30);
    ball.low = std::min(ball.low, q);
  }
  return true;
}

bool Smoother::move(VertId v, int tries) {
  const Part& p = *part_;
  Ball ball;
  if (!gather(v, ball)) return false;
  double gain = 1;
  Vec3 step = p.options.springs ? spring_step(v, ball.free) : newton_step(v, ball.free, gain);
  if (!(gain > kSmallestGain) || !is_finite(step)) return false;
  // The step may not jump out of the ball: at most the size of an element.
  const double length2 = quad(p.mesh.metric[v].m, step);
  if (length2 < 1e-4) return false;
  if (length2 > 0.25) step = (0.5 / std::sqrt(length2)) * step;
  for (int i = 0; i < tries; ++i) {
    if (attempt(v, step, ball.sum, ball.low)) return true;
    step = 0.4 * step;
  }
  return false;
}

Vec3 Smoother::relaxing_step(VertId v, std::size_t links, const Freedom& free, double& strain_sum) const {
  const Part& p = *part_;
  const SymTensor& m = p.mesh.metric[v].m;
  SymTensor h = 0.02 * m;  // where few edges pull, the step stays small
  Vec3 g;
  for (std::size_t i = 0; i < links; ++i) {
    const Vec3 d = p.x(v) - p.x(link_[i]), da = mul(m, d), db = mul(p.mesh.metric[link_[i]].m, d);
    const double qa = dot(d, da), qb = dot(d, db), l = log_mean(std::sqrt(qa), std::sqrt(qb));
    strain_sum += strain(l);
    const double r = std::log(l), u = 2 * std::log2(l), weight = 0.05 + std::min(u * u * u * u, 4.0);
    const Vec3 n = (0.5 / qa) * da + (0.5 / qb) * db;  // gradient of log(l), nearly
    g += (weight * r) * n;
    h = h + weight * SymTensor{n.x * n.x, n.x * n.y, n.y * n.y, n.x * n.z, n.y * n.z, n.z * n.z};
  }
  return minimum(h, g, free.dims, free.t0, free.t1);
}

bool Smoother::move_to_relax(VertId v, double floor_q3) {
  constexpr double kShape = 0.005;  ///< strain that 1/Q^3 of an element counts as
  constexpr double kLeast = 0.01;   ///< strain that a move must take away
  Ball ball;
  if (!gather(v, ball)) return false;
  const Part& p = *part_;
  const std::size_t links = list_link(v);
  double was = kShape * ball.sum;
  const Vec3 x = p.x(v);
  Vec3 step = relaxing_step(v, links, ball.free, was);
  if (!is_finite(step)) return false;
  const double length2 = quad(p.mesh.metric[v].m, step);
  if (length2 > 0.25) step = (0.5 / std::sqrt(length2)) * step;
  for (int i = 0; i < 3; ++i, step = 0.5 * step) {
    SymTensor log_m;
    if (!interpolate(v, step, log_m)) continue;
    const VertMetric m = vert_metric_from_log(log_m);
    const double bound = std::min(ball.low, floor_q3), low = judge(x + step, m, bound);
    if (!(low > 0) || low < bound) continue;
    double is = kShape * cone_.sum_of_inverses();
    for (std::size_t k = 0; k < links; ++k) {
      is += strain(edge_length(m.m, p.mesh.metric[link_[k]].m, x + step - p.x(link_[k])));
    }
    if (is > was - kLeast) continue;
    place(v, x + step, m, log_m);
    return true;
  }
  return false;
}

bool Smoother::move_along_axes(VertId v) {
  Ball ball;
  if (!gather(v, ball)) return false;
  const Part& p = *part_;
  const Vec3 x = p.x(v);
  const SymTensor root = exp(-0.5 * p.mesh.log_metric[v]);  // its columns have length 1
  const Freedom& free = ball.free;
  Vec3 best;
  SymTensor best_log;
  double best_low = 1.01 * ball.low;
  for (const Vec3& column :
       {Vec3{root.xx, root.xy, root.xz}, Vec3{root.xy, root.yy, root.yz}, Vec3{root.xz, root.yz, root.zz}}) {
    Vec3 axis = column;
    if (free.dims < 3) axis = dot(column, free.t0) * free.t0;
    if (free.dims == 2) axis += dot(column, free.t1) * free.t1;
    for (const double size : {0.25, -0.25, 0.1, -0.1, 0.04, -0.04}) {
      SymTensor log_m;
      if (!interpolate(v, size * axis, log_m)) continue;
      const double low = judge(x + size * axis, vert_metric_from_log(log_m), best_low);
      if (low > best_low) best_low = low, best = size * axis, best_log = log_m;
    }
  }
  if (!(dot(best, best) > 0)) return false;
  const VertMetric m = vert_metric_from_log(best_log);
  judge(x + best, m, 0);
  place(v, x + best, m, best_log);
  return true;
}

namespace {
/// An orthonormal basis, in the metric, of the directions of freedom; returns how many.
std::size_t basis(const SymTensor& m, int dims, Vec3 t0, Vec3 t1, std::array<Vec3, 3>& axis) noexcept {
  axis = {t0, t1, Vec3{0, 0, 1}};
  if (dims == 3) axis[0] = {1, 0, 0}, axis[1] = {0, 1, 0};
  const auto n = static_cast<std::size_t>(dims);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) axis[i] = axis[i] - dot(axis[k], mul(m, axis[i])) * axis[k];
    axis[i] = (1 / std::sqrt(quad(m, axis[i]))) * axis[i];
  }
  return n;
}

constexpr double kRefused = 1e300;
/// Where the parabola through the values at -1, 0, 1 is least, not too far off.
double lowest(double minus, double middle, double plus) noexcept {
  const bool left = minus < kRefused, right = plus < kRefused;
  if (!left || !right) return left && minus < middle ? -2 : right && plus < middle ? 2 : 0;
  const double curvature = plus + minus - 2 * middle;
  if (curvature > 0) return std::clamp(0.5 * (minus - plus) / curvature, -4.0, 4.0);
  return plus < minus ? 3 : -3;
}
}  // namespace

bool Smoother::move_to_reduce_sum(VertId v, double floor_q3) {
  constexpr double kGain = 0.998;
  Ball ball;
  if (!gather(v, ball)) return false;
  const Vec3 x = part_->x(v);
  std::array<Vec3, 3> axis;
  const std::size_t dims = basis(part_->mesh.metric[v].m, ball.free.dims, ball.free.t0, ball.free.t1, axis);
  double old_sum = 0;
  for (const FaceId f : ball_) old_sum += inverse_sixth_power(static_cast<double>(part_->q3[face_tet(f)]));

  Vec3 best;
  SymTensor best_log;
  double best_sum = old_sum;
  const double bound = std::min(ball.low, floor_q3);
  const auto look = [&](Vec3 step) {
    SymTensor log_m;
    if (!interpolate(v, step, log_m)) return kRefused;
    const double low = judge(x + step, vert_metric_from_log(log_m), bound);
    if (!(low > 0) || low < bound) return kRefused;
    double sum = 0;
    for (std::size_t i = 0; i < ball_.size(); ++i) sum += inverse_sixth_power(cone_.q3(i));
    if (sum < best_sum) best_sum = sum, best = step, best_log = log_m;
    return sum;
  };
  for (const double h : {0.06, 0.024}) {
    const Vec3 centre = best;
    const double middle = best_sum;
    Vec3 jump;
    for (std::size_t i = 0; i < dims; ++i) {
      const double plus = look(centre + h * axis[i]), minus = look(centre - h * axis[i]);
      jump += (h * lowest(minus, middle, plus)) * axis[i];
    }
    for (const double part : {1.0, 0.5, 0.25}) {
      const double before = best_sum;
      if (look(centre + part * jump) < before) break;
    }
  }
  if (!(best_sum < kGain * old_sum)) return false;
  const VertMetric m = vert_metric_from_log(best_log);
  judge(x + best, m, 0);
  place(v, x + best, m, best_log);
  return true;
}

}  // namespace skein
