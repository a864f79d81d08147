// Neighbours, pieces, normals and tangents of the reference surface.
#include "geometry/surface_builder.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "geometry/hermite.hpp"
#include "geometry/quadric_normal.hpp"

namespace skein {
namespace {

constexpr double kFlat = 1e-6;  ///< between unit normals of facets in one plane, tangents on one line
constexpr double kNearest = 0.25, kTooNear = 0.05;  ///< of an edge: how far away points are that make its tangents
constexpr int kLayers = 2, kLayersAtFeature = 4;    ///< of triangles round a fan, whose points make its normal
constexpr std::size_t next(std::size_t i) noexcept { return i == 2 ? 0 : i + 1; }
bool same_direction(Vec3 a, Vec3 b) noexcept { return norm(cross(a, b)) < kFlat && dot(a, b) > 0; }

}  // namespace

ReferenceSurface::ReferenceSurface(SurfaceInput input, SurfaceShape shape) : in_(std::move(input)), shape_(shape) {
  SurfaceBuilder(*this).build();
  tree_ = SurfaceTree(in_.points, in_.triangles);
}

void SurfaceBuilder::build() {
  s_.patches_.resize(s_.in_.triangles.size());
  s_.curves_.resize(s_.in_.edges.size());
  for (std::size_t e = 0; e < s_.in_.edges.size(); ++e) {
    const auto [a, b] = std::minmax(s_.in_.edges[e][0], s_.in_.edges[e][1]);
    sorted_edges_.push_back({a, b, static_cast<std::int32_t>(e)});
  }
  std::sort(sorted_edges_.begin(), sorted_edges_.end());
  find_neighbours();
  orient_pieces();
  place_points();
  list_around_points();
  find_normals();
  find_curves();
  find_flat();
  find_sides();
}

std::int32_t SurfaceBuilder::feature(std::int32_t a, std::int32_t b) const {
  if (b < a) std::swap(a, b);
  const auto at = std::lower_bound(sorted_edges_.begin(), sorted_edges_.end(), std::array{a, b, std::int32_t{-1}});
  return at != sorted_edges_.end() && (*at)[0] == a && (*at)[1] == b ? (*at)[2] : -1;
}

std::size_t SurfaceBuilder::corner(std::int32_t t, std::int32_t point) const {
  const auto& v = verts(t);
  return static_cast<std::size_t>(std::find(v.begin(), v.end(), point) - v.begin());
}

void SurfaceBuilder::find_neighbours() {
  std::vector<Side> sides;
  for (std::int32_t t = 0; t < count(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(verts(t)[next(i)], verts(t)[next(next(i))]);
      const std::int32_t e = feature(a, b);
      patch(t).curve[i] = e;
      if (e < 0) sides.push_back({a, b, t, static_cast<std::int32_t>(i)});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& l, const Side& r) {
    return std::tie(l.a, l.b, l.triangle) < std::tie(r.a, r.b, r.triangle);
  });
  const auto same = [](const Side& l, const Side& r) { return l.a == r.a && l.b == r.b; };
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const bool more =
        (i > 0 && same(sides[i - 1], sides[i])) || (i + 2 < sides.size() && same(sides[i + 1], sides[i + 2]));
    if (more || !same(sides[i], sides[i + 1])) continue;
    const Side &l = sides[i], &r = sides[i + 1];
    patch(l.triangle).neighbour[static_cast<std::size_t>(l.side)] = r.triangle;
    patch(r.triangle).neighbour[static_cast<std::size_t>(r.side)] = l.triangle;
  }
}

void SurfaceBuilder::flip(std::int32_t t) {
  auto& v = s_.in_.triangles[static_cast<std::size_t>(t)];
  std::swap(v[1], v[2]);
  std::swap(patch(t).neighbour[1], patch(t).neighbour[2]);
  std::swap(patch(t).curve[1], patch(t).curve[2]);
}

void SurfaceBuilder::orient_pieces() {
  std::vector<std::int32_t> stack;
  std::vector<char> seen(s_.patches_.size(), 0);
  std::int32_t pieces = 0;
  // Over a side with its ends p, q, the neighbour must have them as q, p.
  const auto agrees = [&](std::int32_t t, std::size_t side, std::int32_t other) {
    const std::size_t at = corner(other, verts(t)[next(side)]);
    return verts(other)[next(at)] != verts(t)[next(next(side))];
  };
  for (std::int32_t start = 0; start < count(); ++start) {
    if (seen[static_cast<std::size_t>(start)] != 0) continue;
    seen[static_cast<std::size_t>(start)] = 1;
    stack.push_back(start);
    while (!stack.empty()) {
      const std::int32_t t = stack.back();
      stack.pop_back();
      patch(t).piece = pieces;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::int32_t nb = patch(t).neighbour[i];
        if (nb < 0) continue;
        if (seen[static_cast<std::size_t>(nb)] == 0) {
          if (!agrees(t, i, nb)) flip(nb);
          seen[static_cast<std::size_t>(nb)] = 1;
          stack.push_back(nb);
        } else if (!agrees(t, i, nb)) {
          auto& back = patch(nb).neighbour;
          std::replace(back.begin(), back.end(), t, -1);
          patch(t).neighbour[i] = -1;
        }
      }
    }
    ++pieces;
  }
}

void SurfaceBuilder::place_points() {
  s_.places_.assign(s_.in_.points.size(), SurfacePlace::kUnknown);
  const auto place = [&](std::int32_t v) -> SurfacePlace& { return s_.places_[static_cast<std::size_t>(v)]; };
  for (std::int32_t t = count(); t-- > 0;) {
    auto& p = patch(t);
    for (std::size_t i = 0; i < 3; ++i) p.x[i] = x(verts(t)[i]), place(verts(t)[i]) = on_triangle(t);
    p.facet_normal = normalized(cross(p.x[1] - p.x[0], p.x[2] - p.x[0]));
  }
  for (std::size_t e = s_.in_.edges.size(); e-- > 0;) {
    // A corner is on several edges, of which the one that matters is known from its neighbour.
    for (const std::int32_t v : s_.in_.edges[e]) {
      const bool corner = s_.in_.is_corner[static_cast<std::size_t>(v)] != 0;
      place(v) = corner ? SurfacePlace::kUnknown : on_edge(static_cast<std::int32_t>(e));
    }
  }
}

void SurfaceBuilder::list_around_points() {
  first_.assign(s_.in_.points.size() + 1, 0);
  for (const auto& t : s_.in_.triangles) {
    for (const std::int32_t v : t) ++first_[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  around_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<std::int32_t> at(first_.begin(), first_.end() - 1);
  for (std::int32_t t = 0; t < count(); ++t) {
    for (const std::int32_t v : verts(t)) around_[static_cast<std::size_t>(at[static_cast<std::size_t>(v)]++)] = t;
  }
}

std::vector<std::int32_t> SurfaceBuilder::fan_of(std::int32_t t, std::int32_t point) const {
  std::vector<std::int32_t> fan{t};
  for (std::size_t i = 0; i < fan.size(); ++i) {
    const std::size_t c = corner(fan[i], point);
    for (const std::size_t side : {next(c), next(next(c))}) {
      const std::int32_t nb = patch(fan[i]).neighbour[side];
      if (nb >= 0 && std::find(fan.begin(), fan.end(), nb) == fan.end()) fan.push_back(nb);
    }
  }
  return fan;
}

Vec3 SurfaceBuilder::mean_normal(const std::vector<std::int32_t>& fan, std::int32_t point, bool& flat) const {
  Vec3 sum;
  flat = true;
  for (const std::int32_t t : fan) {
    const std::size_t c = corner(t, point);
    const auto& p = patch(t);
    const Vec3 u = normalized(p.x[next(c)] - p.x[c]), v = normalized(p.x[next(next(c))] - p.x[c]);
    sum += std::acos(std::clamp(dot(u, v), -1.0, 1.0)) * p.facet_normal;
    flat = flat && same_direction(p.facet_normal, patch(fan.front()).facet_normal);
  }
  return normalized(sum);
}

bool SurfaceBuilder::is_open(const std::vector<std::int32_t>& fan, std::int32_t point) const {
  return std::any_of(fan.begin(), fan.end(), [&](std::int32_t t) {
    const std::size_t c = corner(t, point);
    return patch(t).neighbour[next(c)] < 0 || patch(t).neighbour[next(next(c))] < 0;
  });
}

bool SurfaceBuilder::is_flat_round(const std::vector<std::int32_t>& fan, int layers) const {
  const Vec3 n = patch(fan.front()).facet_normal;
  const auto near = triangles_round(fan, layers);
  return std::all_of(near.begin(), near.end(),
                     [&](std::int32_t t) { return same_direction(patch(t).facet_normal, n); });
}

std::vector<std::int32_t> SurfaceBuilder::triangles_round(const std::vector<std::int32_t>& fan, int layers) const {
  std::vector<std::int32_t> near = fan;
  std::size_t from = 0;
  for (int layer = 0; layer < layers; ++layer) {
    for (const std::size_t end = near.size(); from < end; ++from) {
      for (const std::int32_t nb : patch(near[from]).neighbour) {
        if (nb >= 0 && std::find(near.begin(), near.end(), nb) == near.end()) near.push_back(nb);
      }
    }
  }
  return near;
}

std::vector<Vec3> SurfaceBuilder::points_round(const std::vector<std::int32_t>& fan, int layers) const {
  std::vector<std::int32_t> points;
  for (const std::int32_t t : triangles_round(fan, layers))
    points.insert(points.end(), verts(t).begin(), verts(t).end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<Vec3> out;
  for (const std::int32_t v : points) out.push_back(x(v));
  return out;
}

void SurfaceBuilder::find_normals() {
  std::vector<std::array<char, 3>> done(s_.patches_.size());
  for (std::int32_t t = 0; t < count(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (done[static_cast<std::size_t>(t)][k] != 0) continue;
      const std::int32_t point = verts(t)[k];
      const auto fan = fan_of(t, point);
      bool flat = true;
      Vec3 n = mean_normal(fan, point, flat);
      // Round an inner point of a plane, what lies beyond counts for nothing. At a feature it does: a wing's trailing
      // edge is a straight line, and so are the facets there.
      const int layers = is_open(fan, point) ? kLayersAtFeature : kLayers;
      if (flat && layers == kLayersAtFeature) flat = is_flat_round(fan, layers);
      if (!flat) n = quadric_normal(x(point), points_round(fan, layers), n);
      for (const std::int32_t f : fan) {
        const std::size_t c = corner(f, point);
        patch(f).normal[c] = flat ? patch(f).facet_normal : n;
        done[static_cast<std::size_t>(f)][c] = 1;
      }
    }
  }
}

std::int32_t SurfaceBuilder::point_along(std::size_t e, std::size_t end, double least) const {
  const auto& in = s_.in_;
  std::int32_t at = in.edges[e][end];
  const Vec3 from = x(at);
  std::int32_t edge = static_cast<std::int32_t>(e), to = s_.curves_[e].next[end];
  while (to >= 0 && to != static_cast<std::int32_t>(e) && norm(x(at) - from) < least) {
    edge = to;
    const auto& v = in.edges[static_cast<std::size_t>(edge)];
    const std::size_t near = v[0] == at ? 0 : 1;
    at = v[1 - near];
    to = s_.curves_[static_cast<std::size_t>(edge)].next[1 - near];
  }
  return at;
}

Vec3 SurfaceBuilder::tangent(std::size_t e, std::size_t end) const {
  const Vec3 from = x(s_.in_.edges[e][end]), to = x(s_.in_.edges[e][1 - end]);
  const double length = norm(to - from);
  const auto circle = [&](Vec3 before, Vec3 at, Vec3 after) {  // of the circle through three points, at the middle one
    const Vec3 l = at - before, r = after - at;
    return normalized((1 / dot(l, l)) * l + (1 / dot(r, r)) * r);
  };
  // Points much nearer than the edge is long would tell more of rounding than of the curve.
  const Vec3 before = x(point_along(e, end, kNearest * length));
  if (norm(before - from) >= kTooNear * length) return circle(before, from, to);
  const Vec3 beyond = x(point_along(e, 1 - end, kNearest * length));
  if (norm(beyond - to) < kTooNear * length) return normalized(to - from);
  // At a corner: the circle through the next two points.
  const Vec3 at_to = circle(from, to, beyond), chord = normalized(to - from);
  return 2 * dot(chord, at_to) * chord - at_to;
}

void SurfaceBuilder::find_curves() {
  const auto& in = s_.in_;
  std::vector<std::array<std::int32_t, 3>> at(in.points.size(), {0, -1, -1});  // how many, and two of them
  for (std::size_t e = 0; e < in.edges.size(); ++e) {
    for (const std::int32_t v : in.edges[e]) {
      auto& list = at[static_cast<std::size_t>(v)];
      if (list[0] < 2) list[static_cast<std::size_t>(list[0]) + 1] = static_cast<std::int32_t>(e);
      ++list[0];
    }
  }
  for (std::size_t e = 0; e < in.edges.size(); ++e) {
    for (std::size_t end = 0; end < 2; ++end) {
      const auto v = static_cast<std::size_t>(in.edges[e][end]);
      if (in.is_corner[v] == 0 && at[v][0] == 2)
        s_.curves_[e].next[end] = at[v][1] == static_cast<std::int32_t>(e) ? at[v][2] : at[v][1];
    }
  }
  for (std::size_t e = 0; e < in.edges.size(); ++e) {
    auto& c = s_.curves_[e];
    c.x0 = x(in.edges[e][0]), c.x1 = x(in.edges[e][1]);
    const Vec3 d = c.x1 - c.x0, chord = normalized(d), t0 = tangent(e, 0), t1 = -1.0 * tangent(e, 1);
    c.straight = s_.shape_ == SurfaceShape::kFacets || (same_direction(t0, chord) && same_direction(t1, chord));
    c.d0 = c.straight ? d : end_derivative(d, t0);
    c.d1 = c.straight ? d : end_derivative(d, t1);
  }
}

void SurfaceBuilder::find_flat() {
  for (std::int32_t t = 0; t < count(); ++t) {
    auto& p = patch(t);
    p.flat = s_.shape_ == SurfaceShape::kFacets ||
             std::all_of(p.normal.begin(), p.normal.end(), [&](Vec3 n) { return same_direction(n, p.facet_normal); });
  }
}

void SurfaceBuilder::find_sides() {
  for (std::int32_t t = 0; t < count(); ++t) {
    auto& p = patch(t);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = next(i), k = next(j);
      const Vec3 d = p.x[k] - p.x[j];
      const std::int32_t e = feature(verts(t)[j], verts(t)[k]);
      if (e < 0) {
        p.derivative[i] = {end_derivative_on(d, p.normal[j]), end_derivative_on(d, p.normal[k])};
        continue;
      }
      const auto& c = s_.curves_[static_cast<std::size_t>(e)];
      p.straight = p.straight && c.straight;
      const bool along = s_.in_.edges[static_cast<std::size_t>(e)][0] == verts(t)[j];
      p.derivative[i] = along ? std::array{c.d0, c.d1} : std::array{-1.0 * c.d1, -1.0 * c.d0};
    }
  }
}

}  // namespace skein
