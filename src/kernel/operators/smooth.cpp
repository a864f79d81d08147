// Moving a vertex: the search for a better place, one for each objective.
#include "kernel/operators/smooth.hpp"

#include <algorithm>

namespace skein {
namespace {

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

double Smoother::judge(const Place& place, double bound) {
  double low = cone_.judge(place.x, place.m);
  if (part_->quality_measure == QualityMeasure::kLargestMetric || !(low > 0) || low < bound) return low;
  for (std::size_t i = 0; i < ball_.size() && low >= bound; ++i) {
    const auto k = part_->mesh.verts(ball_[i]);
    const auto& y = part_->mesh.coords;
    const auto& n = part_->mesh.metric;
    const double q = least_quality_cubed(place.x, y[k[0]], y[k[1]], y[k[2]], place.m, n[k[0]], n[k[1]], n[k[2]]);
    cone_.set_q3(i, q);
    low = std::min(low, q);
  }
  return low;
}

bool Smoother::find_place(VertId v, Vec3 step, Place& place) {
  const Part& p = *part_;
  if (!interpolate(v, step, place.log_m)) return false;
  place.x = p.x(v) + step;
  if (p.mesh.has(v, kSurface | kRidge)) {
    const BoundaryPoint on = p.geometry->project(p.mesh, v, place.x);
    place.x = on.x, place.on = on.place;
  }
  place.m = vert_metric_from_log(place.log_m);
  return true;
}

void Smoother::put(VertId v, const Place& place) {
  part_->mesh.coords[v] = place.x;
  part_->mesh.metric[v] = place.m;
  part_->mesh.log_metric[v] = place.log_m;
  if (!part_->mesh.surface_place.empty()) part_->mesh.surface_place[v] = place.on;
  mark_changed(v);
  ++part_->counts.smooth;
}

template <class Objective>
bool Smoother::move(VertId v, const Objective& objective) {
  Ball ball;
  Place best;
  if (!gather(v, ball) || !search(v, ball, objective, best)) return false;
  const TetMesh& m = part_->mesh;
  if (m.has(v, kSurface) && !part_->geometry->allows_move(m, v, best.x, facets_)) return false;
  put(v, best);
  return true;
}
template bool Smoother::move(VertId, const SmoothBall&);
template bool Smoother::move(VertId, const RaiseWorst&);
template bool Smoother::move(VertId, const LowerSum&);
template bool Smoother::move(VertId, const LowerStrain&);
template bool Smoother::move(VertId, const ToSurface&);

bool Smoother::search(VertId v, const Ball& ball, const SmoothBall& objective, Place& best) {
  const Part& p = *part_;
  const Method::Smooth& o = p.options.method.smooth;
  double gain = 1;
  const bool springs = p.options.method.smoothing == Smoothing::kSprings;
  Vec3 step = springs ? spring_step(v, ball.free) : newton_step(v, ball.free, gain);
  if (!(gain > o.least_gain) || !is_finite(step)) return false;
  // The step may not jump out of the ball: at most the size of an element.
  const double length2 = quad(p.mesh.metric[v].m, step);
  if (length2 < o.shortest_step * o.shortest_step) return false;
  if (length2 > o.longest_step * o.longest_step) step = (o.longest_step / std::sqrt(length2)) * step;
  const double bound = std::min(ball.low, cube(o.good_quality));
  for (int i = 0; i < objective.tries; ++i) {
    if (find_place(v, step, best)) {
      const double low = judge(best, bound);
      if (low > 0 && low >= bound && cone_.sum_of_inverses() < o.sum_share * ball.sum) return true;
    }
    step = o.shorter * step;
  }
  return false;
}

bool Smoother::search(VertId v, const Ball& ball, const ToSurface& objective, Place& best) {
  const Part& p = *part_;
  const BoundaryPoint on = p.geometry->project(p.mesh, v, p.x(v));
  const Vec3 way = on.x - p.x(v);
  const double bound = objective.bound(ball.low);
  for (double share = 1; share > 0.1; share *= 0.5) {
    if (!interpolate(v, share * way, best.log_m)) continue;
    best = {share == 1 ? on.x : p.x(v) + share * way, best.log_m, vert_metric_from_log(best.log_m), on.place};
    const double low = judge(best, bound);
    if (low > 0 && low >= bound) return true;
  }
  return false;
}

Vec3 Smoother::strain_step(VertId v, std::size_t links, const Freedom& free, double& strain_sum) const {
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

bool Smoother::search(VertId v, const Ball& ball, const LowerStrain& objective, Place& best) {
  const Part& p = *part_;
  const Method::Strain& o = p.options.method.strain;
  const std::size_t links = list_link(v);
  double was = o.shape * ball.sum;
  Vec3 step = strain_step(v, links, ball.free, was);
  if (!is_finite(step)) return false;
  const double length2 = quad(p.mesh.metric[v].m, step), longest = p.options.method.smooth.longest_step;
  if (length2 > longest * longest) step = (longest / std::sqrt(length2)) * step;
  const double bound = objective.bound(ball.low);
  for (int i = 0; i < 3; ++i, step = 0.5 * step) {
    if (!find_place(v, step, best)) continue;
    const double low = judge(best, bound);
    if (!(low > 0) || low < bound) continue;
    double is = o.shape * cone_.sum_of_inverses();
    for (std::size_t k = 0; k < links; ++k) {
      is += strain(edge_length(best.m.m, p.mesh.metric[link_[k]].m, best.x - p.x(link_[k])));
    }
    if (is <= was - o.least_decrease) return true;
  }
  return false;
}

bool Smoother::search(VertId v, const Ball& ball, const RaiseWorst& objective, Place& best) {
  const SymTensor root = exp(-0.5 * part_->mesh.log_metric[v]);  // its columns have length 1
  const Freedom& free = ball.free;
  Place place;
  double best_low = objective.bound(ball.low);
  bool found = false;
  for (const Vec3& column :
       {Vec3{root.xx, root.xy, root.xz}, Vec3{root.xy, root.yy, root.yz}, Vec3{root.xz, root.yz, root.zz}}) {
    Vec3 axis = column;
    if (free.dims < 3) axis = dot(column, free.t0) * free.t0;
    if (free.dims == 2) axis += dot(column, free.t1) * free.t1;
    for (const double size : {0.25, -0.25, 0.1, -0.1, 0.04, -0.04}) {
      if (!find_place(v, size * axis, place)) continue;
      const double low = judge(place, best_low);
      if (low > best_low) best_low = low, best = place, found = true;
    }
  }
  if (found) judge(best, 0);
  return found;
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

constexpr double kRefused = 1e300;  ///< where a vertex cannot go
/// Where the parabola through the values at -1, 0, 1 is least, not too far off.
double lowest(double minus, double middle, double plus) noexcept {
  const bool left = minus < kRefused, right = plus < kRefused;
  if (!left || !right) return left && minus < middle ? -2 : right && plus < middle ? 2 : 0;
  const double curvature = plus + minus - 2 * middle;
  if (curvature > 0) return std::clamp(0.5 * (minus - plus) / curvature, -4.0, 4.0);
  return plus < minus ? 3 : -3;
}
}  // namespace

bool Smoother::search(VertId v, const Ball& ball, const LowerSum& objective, Place& best) {
  std::array<Vec3, 3> axis;
  const std::size_t dims = basis(part_->mesh.metric[v].m, ball.free.dims, ball.free.t0, ball.free.t1, axis);
  double old_sum = 0;
  for (const FaceId f : ball_) old_sum += inverse_sixth_power(static_cast<double>(part_->q3[face_tet(f)]));

  Vec3 best_step;
  Place place;
  double best_sum = old_sum;
  const double bound = objective.bound(ball.low);
  const auto look = [&](Vec3 step) {
    if (!find_place(v, step, place)) return kRefused;
    const double low = judge(place, bound);
    if (!(low > 0) || low < bound) return kRefused;
    double sum = 0;
    for (std::size_t i = 0; i < ball_.size(); ++i) sum += inverse_sixth_power(cone_.q3(i));
    if (sum < best_sum) best_sum = sum, best_step = step, best = place;
    return sum;
  };
  for (const double h : {0.06, 0.024}) {
    const Vec3 centre = best_step;
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
  if (!(best_sum < objective.sum_share * old_sum)) return false;
  judge(best, 0);
  return true;
}

}  // namespace skein
