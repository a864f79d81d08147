// Points of the reference surface.
#include "geometry/reference_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/hermite.hpp"

namespace skein {
namespace {

constexpr int kMostHops = 64;  ///< triangles or edges that a walk crosses before the tree is asked
constexpr int kMostSteps = 8;  ///< of the iteration to the foot of a perpendicular
constexpr double kSettled = 1e-13;
constexpr double kFarBeyond = 0.1;   ///< barycentric: a curved feature bulges less beyond its chord
constexpr double kSameSheet = -0.2;  ///< cosine between normals of places of one sheet that are near each other
using Weights = std::array<double, 3>;

constexpr std::size_t next(std::size_t i) noexcept { return i == 2 ? 0 : i + 1; }

/// Barycentric coordinates of the foot of x in the plane of the triangle, or of the direction d (sum 0).
Weights weights_of(const std::array<Vec3, 3>& p, Vec3 x) noexcept {
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], d = x - p[0];
  const Vec3 n = cross(u, v);
  const double n2 = dot(n, n);
  if (!(n2 > 0)) return {1, 0, 0};
  const double w1 = dot(cross(d, v), n) / n2, w2 = dot(cross(u, d), n) / n2;
  return {1 - w1 - w2, w1, w2};
}

Weights clamped(const Weights& w) noexcept {
  Weights c{};
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += c[i] = std::max(w[i], 0.0);
  for (double& v : c) v /= sum;
  return c;
}

std::size_t lowest(const Weights& w) noexcept { return w[0] <= w[1] ? (w[0] <= w[2] ? 0 : 2) : (w[1] <= w[2] ? 1 : 2); }

}  // namespace

Vec3 ReferenceSurface::normal_at(std::int32_t t, const Weights& w) const noexcept {
  const Patch& p = tri(t);
  if (p.flat) return p.facet_normal;
  return normalized(w[0] * p.normal[0] + w[1] * p.normal[1] + w[2] * p.normal[2]);
}

Vec3 ReferenceSurface::evaluate(std::int32_t t, const Weights& w) const noexcept {
  const Patch& p = tri(t);
  if (p.flat && p.straight) return w[0] * p.x[0] + w[1] * p.x[1] + w[2] * p.x[2];
  // From each corner to the point opposite it; the three results are blended so that each counts alone on its side.
  Vec3 sum;
  double total = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = next(i), k = next(j);
    const double across = w[j] + w[k];
    if (!(across > 0)) return p.x[i];
    const double blend = w[j] * w[j] * w[k] * w[k];
    if (blend == 0 && w[i] > 0 && w[j] * w[k] == 0) {
      if (w[j] == 0 && w[k] == 0) return p.x[i];
      continue;
    }
    const double s = w[k] / across;
    const auto& m = p.derivative[i];
    const Vec3 foot = hermite(p.x[j], m[0], p.x[k], m[1], s);
    if (w[i] == 0) return foot;
    const Vec3 along = normalized(hermite_derivative(p.x[j], m[0], p.x[k], m[1], s));
    const Vec3 blended = (1 - s) * p.normal[j] + s * p.normal[k];
    const Vec3 n = normalized(blended - dot(blended, along) * along);
    const Vec3 d = foot - p.x[i];
    const Vec3 point = hermite(p.x[i], end_derivative_on(d, p.normal[i]), foot, end_derivative_on(d, n), across);
    sum += blend * point;
    total += blend;
  }
  if (total > 0) return (1 / total) * sum;
  // On a side, next to a corner.
  const std::size_t i = lowest(w), j = next(i), k = next(j);
  return hermite(p.x[j], p.derivative[i][0], p.x[k], p.derivative[i][1], w[k] / (w[j] + w[k]));
}

bool ReferenceSurface::walk(Vec3 x, std::int32_t& t, Weights& w) const noexcept {
  std::int32_t before = -1;
  for (int hop = 0; hop < kMostHops; ++hop) {
    const Patch& p = tri(t);
    w = weights_of(p.x, x);
    // Over the side that x is farthest beyond, of those that have something behind them.
    std::size_t side = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      if (w[i] < 0 && p.neighbour[i] >= 0 && (side == 3 || w[i] < w[side])) side = i;
    }
    if (side == 3 || p.neighbour[side] == before) {
      // Over a convex side both triangles send it back. Far beyond a side with nothing behind, the way may lead round.
      const bool far = side == 3 && w[lowest(w)] < -kFarBeyond;
      w = nearest_on_triangle(x, p.x[0], p.x[1], p.x[2]).weight;
      return !far;
    }
    before = t;
    t = p.neighbour[side];
  }
  return false;
}

std::int32_t ReferenceSurface::search(Vec3 x, SurfacePlace from) const noexcept {
  const auto search_if = [&](auto&& fits) { return tree_.nearest(in_.points, in_.triangles, x, fits); };
  if (!is_triangle(from)) return search_if([](std::int32_t) { return true; });
  const Patch& home = tri(triangle_of(from));
  return search_if([&](std::int32_t t) {
    return tri(t).piece == home.piece && dot(tri(t).facet_normal, home.facet_normal) > kSameSheet;
  });
}

SurfacePoint ReferenceSurface::settle(Vec3 x, std::int32_t t, Weights w, double settled) const noexcept {
  SurfacePoint out;
  int hops = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Patch& p = tri(t);
    const Vec3 n = normal_at(t, w);
    out = {evaluate(t, w), on_triangle(t), n, p.flat};
    if (p.flat) return out;
    const Vec3 off = x - out.x;
    const Vec3 aside = off - dot(off, n) * n;
    const Weights zero = weights_of(p.x, p.x[0]), change = weights_of(p.x, p.x[0] + aside);
    Weights to{};
    double moved = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      to[i] = w[i] + change[i] - zero[i];
      moved = std::max(moved, std::abs(change[i] - zero[i]));
    }
    if (moved < settled) return out;
    const std::size_t side = lowest(to);
    if (to[side] < -1e-9 && p.neighbour[side] >= 0 && hops < 3) {
      t = p.neighbour[side];
      ++hops;
      const auto& q = tri(t).x;
      w = nearest_on_triangle(x - dot(off, n) * n, q[0], q[1], q[2]).weight;
    } else {
      to = clamped(to);
      if (to == w) return out;
      w = to;
    }
  }
  return out;
}

SurfacePoint ReferenceSurface::find(Vec3 x, SurfacePlace from, double settled) const {
  Weights w{};
  if (is_edge(from)) from = SurfacePlace::kUnknown;
  std::int32_t t = triangle_of(from);
  if (!is_triangle(from) || !walk(x, t, w)) {
    t = search(x, from);
    if (t < 0) return {x, SurfacePlace::kUnknown, {}, true};
    const auto& p = tri(t).x;
    w = nearest_on_triangle(x, p[0], p[1], p[2]).weight;
  }
  return settle(x, t, w, settled);
}

SurfacePoint ReferenceSurface::nearest_of_patch(Vec3 x, std::int32_t patch) const {
  const std::int32_t t = tree_.nearest(in_.points, in_.triangles, x,
                                       [&](std::int32_t i) { return in_.patch[static_cast<std::size_t>(i)] == patch; });
  if (t < 0) return {x, SurfacePlace::kUnknown, {}, true};
  const auto& p = tri(t).x;
  return settle(x, t, nearest_on_triangle(x, p[0], p[1], p[2]).weight, kExactly);
}

double ReferenceSurface::distance(Vec3 x, SurfacePlace from) const {
  if (is_edge(from)) return norm(x - nearest_on_edges(x, from).x);
  const SurfacePoint p = nearest(x, from);
  const Vec3 off = x - p.x;
  return p.flat && shape_ == SurfaceShape::kPatches ? std::abs(dot(off, p.direction)) : norm(off);
}

SurfacePoint ReferenceSurface::nearest_on_edges(Vec3 x, SurfacePlace from) const {
  const auto share = [&](const Curve& c) {
    const Vec3 d = c.x1 - c.x0;
    return dot(x - c.x0, d) / dot(d, d);
  };
  std::int32_t e = edge_of(from);
  if (!is_edge(from)) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      const Curve& c = curves_[i];
      const Vec3 off = x - (c.x0 + std::clamp(share(c), 0.0, 1.0) * (c.x1 - c.x0));
      if (dot(off, off) < least) least = dot(off, off), e = static_cast<std::int32_t>(i);
    }
    if (!(least < std::numeric_limits<double>::infinity())) return {x, SurfacePlace::kUnknown, {}, true};
  }
  std::int32_t before = -1;
  double s = share(curve(e));
  for (int hop = 0; hop < kMostHops && (s < 0 || s > 1); ++hop) {
    const std::int32_t to = curve(e).next[s < 0 ? 0 : 1];
    if (to < 0 || to == before) break;
    before = e;
    e = to;
    s = share(curve(e));
  }
  s = std::clamp(s, 0.0, 1.0);
  const Curve& c = curve(e);
  const auto point = [&] { return hermite(c.x0, c.d0, c.x1, c.d1, s); };
  const auto slope = [&] { return hermite_derivative(c.x0, c.d0, c.x1, c.d1, s); };
  for (int step = 0; step < kMostSteps && !c.straight; ++step) {
    const Vec3 d = slope();
    const double to = std::clamp(s + dot(x - point(), d) / dot(d, d), 0.0, 1.0);
    if (std::abs(to - s) < kSettled) break;
    s = to;
  }
  return {point(), on_edge(e), normalized(slope()), c.straight};
}

double ReferenceSurface::allowed_deviation(SurfacePlace place) const noexcept {
  if (limit_.empty()) return std::numeric_limits<double>::infinity();
  if (is_edge(place)) return edge_limit_[static_cast<std::size_t>(edge_of(place))];
  return is_triangle(place) ? limit_[static_cast<std::size_t>(tri(triangle_of(place)).piece)] : least_limit_;
}

void ReferenceSurface::limit_deviation(double share, double narrow_share, std::span<const double> most) {
  struct Piece {
    Box box = kEmptyBox;
    double area = 0, rim = 0, most = std::numeric_limits<double>::infinity();
  };
  std::vector<Piece> pieces;
  for (std::size_t t = 0; t < patches_.size(); ++t) {
    const Patch& p = patches_[t];
    if (pieces.size() <= static_cast<std::size_t>(p.piece)) pieces.resize(static_cast<std::size_t>(p.piece) + 1);
    Piece& piece = pieces[static_cast<std::size_t>(p.piece)];
    for (const Vec3 x : p.x) piece.box = join(piece.box, x);
    piece.area += 0.5 * norm(cross(p.x[1] - p.x[0], p.x[2] - p.x[0]));
    for (std::size_t i = 0; i < 3; ++i) piece.rim += p.curve[i] >= 0 ? norm(p.x[next(i)] - p.x[next(next(i))]) : 0;
    piece.most = std::min(piece.most, most[t]);
  }
  limit_.clear();
  least_limit_ = std::numeric_limits<double>::infinity();
  for (const Piece& p : pieces) {
    double limit = std::min(p.most, share * norm(p.box.high - p.box.low));
    if (p.rim > 0 && narrow_share > 0) limit = std::min(limit, narrow_share * p.area / p.rim);
    limit_.push_back(limit);
    least_limit_ = std::min(least_limit_, limit);
  }
  edge_limit_.assign(curves_.size(), std::numeric_limits<double>::infinity());
  for (const Patch& p : patches_) {
    for (const std::int32_t e : p.curve) {
      if (e < 0) continue;
      double& limit = edge_limit_[static_cast<std::size_t>(e)];
      limit = std::min(limit, limit_[static_cast<std::size_t>(p.piece)]);
    }
  }
}

double ReferenceSurface::edge_length(std::int32_t e) const noexcept {
  const Curve& c = curve(e);
  if (c.straight) return chord(e);
  constexpr int kParts = 8;
  double sum = 0;
  Vec3 last = c.x0;
  for (int i = 1; i <= kParts; ++i) {
    const Vec3 x = hermite(c.x0, c.d0, c.x1, c.d1, static_cast<double>(i) / kParts);
    sum += norm(x - last);
    last = x;
  }
  return sum;
}

ReferenceSurface::Gain ReferenceSurface::gain(std::int32_t t) const noexcept {
  const Patch& p = tri(t);
  if (p.straight && p.flat) return {};
  constexpr int kParts = 4;  // of a side
  const auto point = [&](int i, int j) {
    const double a = static_cast<double>(i) / kParts, b = static_cast<double>(j) / kParts;
    return evaluate(t, {i + j == kParts ? 0 : 1 - a - b, a, b});
  };
  Gain sum;
  const Vec3 origin = in_.points.front();
  const auto add = [&](Vec3 a, Vec3 b, Vec3 c, double sign) {
    sum.area += sign * 0.5 * norm(cross(b - a, c - a));
    sum.volume += sign * volume6(origin, a, b, c) / 6;
  };
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; i + j < kParts; ++j) {
      add(point(i, j), point(i + 1, j), point(i, j + 1), 1);
      if (i + j + 1 < kParts) add(point(i + 1, j), point(i + 1, j + 1), point(i, j + 1), 1);
    }
  }
  add(p.x[0], p.x[1], p.x[2], -1);
  return sum;
}

}  // namespace skein
