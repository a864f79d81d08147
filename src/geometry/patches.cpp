// The boundary on curved patches.
#include "geometry/patches.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace skein {
namespace {

constexpr double kFlat = 1e-9;     ///< relative height up to which facets count as one plane
constexpr double kFarthest = 0.5;  ///< of an edge: a surface that is farther off is not the one that it belongs to

double cosine(double degrees) noexcept { return std::cos(degrees * std::numbers::pi / 180); }
using Triangle = std::array<Vec3, 3>;
Vec3 area_vector(const Triangle& t) noexcept { return cross(t[1] - t[0], t[2] - t[0]); }

/// x where the surface is flat and it is on it already; otherwise its foot there.
BoundaryPoint on_flat(Vec3 x, const SurfacePoint& p, double size) noexcept {
  const double height = dot(x - p.x, p.direction);
  return {std::abs(height) <= kFlat * size ? x : x - height * p.direction, p.place};
}
BoundaryPoint on_straight(Vec3 x, const SurfacePoint& p, double size) noexcept {
  const Vec3 off = x - p.x, aside = off - dot(off, p.direction) * p.direction;
  return {norm(aside) <= kFlat * size ? x : x - aside, p.place};
}

/// Both old and new triangles are in one plane.
bool in_one_plane(const Triangle& was, const Triangle& is) noexcept {
  const Vec3 n = normalized(area_vector(was));
  const double size = std::max(norm(was[1] - was[0]), norm(was[2] - was[0]));
  return std::all_of(is.begin(), is.end(), [&](Vec3 x) { return std::abs(dot(x - was[0], n)) <= kFlat * size; });
}

}  // namespace

PatchGeometry::PatchGeometry(const FacetLimits& flat, const PatchLimits& limits, const ReferenceSurface& reference)
    : flat_(flat), min_dot_(cosine(limits.max_turn)), min_cosine_(cosine(limits.max_angle)), reference_(&reference) {}

BoundaryPoint PatchGeometry::lift(const TetMesh& m, VertId a, VertId b, Vec3 x, EdgeKind kind) const {
  if (kind != EdgeKind::kRidge && kind != EdgeKind::kSurface) return {x};
  const auto [first, second] = std::minmax(m.surface_place[a], m.surface_place[b]);
  const double size = norm(m.coords[b] - m.coords[a]);
  SurfacePoint p;
  if (kind == EdgeKind::kRidge) {
    // Edges count downwards from -2: the first is one if any is.
    p = reference_->nearest_on_edges(x, is_edge(second) ? second : first);
    if (p.flat) return on_straight(x, p, size);
  } else {
    p = reference_->near(x, is_triangle(first) ? first : second);
    if (p.flat) return on_flat(x, p, size);
  }
  if (norm(p.x - x) > kFarthest * size) return {x};
  return {p.x, p.place};
}

BoundaryPoint PatchGeometry::between(const TetMesh& m, VertId a, VertId b, double s, EdgeKind kind) const {
  return lift(m, a, b, flat_.between(m, a, b, s, kind).x, kind);
}

BoundaryPoint PatchGeometry::middle(const TetMesh& m, VertId a, VertId b, EdgeKind kind) const {
  return lift(m, a, b, flat_.middle(m, a, b, kind).x, kind);
}

BoundaryPoint PatchGeometry::project(const TetMesh& m, VertId v, Vec3 x) const {
  const SurfacePlace at = m.surface_place[v];
  const double size = norm(x - m.coords[v]);
  if (is_edge(at)) {
    const SurfacePoint p = reference_->nearest_on_edges(x, at);
    return p.flat ? on_straight(x, p, size) : BoundaryPoint{p.x, p.place};
  }
  if (!is_triangle(at)) return {x};
  const SurfacePoint p = reference_->near(x, at);
  return p.flat ? on_flat(x, p, size) : BoundaryPoint{p.x, p.place};
}

double PatchGeometry::distance(const TetMesh& m, VertId v) const {
  const SurfacePlace at = m.surface_place[v];
  const Vec3 x = m.coords[v];
  return at == SurfacePlace::kUnknown ? 0 : reference_->distance(x, at);
}

std::optional<Freedom> PatchGeometry::freedom(const TetMesh& m, VertId v, const BoundaryStar& star) const {
  const SurfacePlace at = m.surface_place[v];
  if (m.has(v, kRidge)) {
    if (!is_edge(at) || star.ridge_ends[1] == kNoVert) return flat_.freedom(m, v, star);
    const SurfacePoint p = reference_->nearest_on_edges(m.coords[v], at);
    if (p.flat) return flat_.freedom(m, v, star);
    return Freedom{1, p.direction, {}};
  }
  if (!is_triangle(at)) return flat_.freedom(m, v, star);
  const SurfacePoint p = reference_->below(m.coords[v], at);
  if (p.flat) return flat_.freedom(m, v, star);
  const Vec3 axis = std::abs(p.direction.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Freedom free{2, normalized(cross(p.direction, axis)), {}};
  free.t1 = cross(p.direction, free.t0);
  return free;
}

template <class Worst>
bool PatchGeometry::is_near(const Deviation& is, Worst&& worst) const {
  if (is.distance <= is.allowed && is.cosine >= min_cosine_) return true;
  const Deviation& was = worst();
  return is.distance <= std::max(is.allowed, was.distance) && is.cosine >= std::min(min_cosine_, was.cosine);
}

namespace {
/// The worst of several facets, found when it is first asked for.
template <class Facets, class Of>
class Worst {
 public:
  Worst(const Facets& facets, Of of) : facets_(facets), of_(std::move(of)) {}
  const Deviation& operator()() {
    if (known_) return worst_;
    for (const auto& f : facets_) {
      const Deviation d = of_(f);
      worst_.distance = std::max(worst_.distance, d.distance);
      worst_.cosine = std::min(worst_.cosine, d.cosine);
    }
    known_ = true;
    return worst_;
  }

 private:
  const Facets& facets_;
  Of of_;
  Deviation worst_;
  bool known_ = false;
};
}  // namespace

bool PatchGeometry::allows_collapse(const TetMesh& m, VertId v, VertId u, std::span<const Facet> facets) const {
  bool flat = true;
  double least = 1e300, size = 0;  // height of v over the new facets
  const auto shape = [&](VertId a, const Facet& f) { return Triangle{m.coords[a], m.coords[f.x], m.coords[f.y]}; };
  for (const Facet& f : facets) {
    if (f.x == u || f.y == u) continue;
    const Triangle was = shape(v, f), is = shape(u, f);
    const Vec3 nw = area_vector(was), ni = area_vector(is);
    const double li = norm(ni);
    if (!(dot(nw, ni) > min_dot_ * norm(nw) * li) || !(li > 0)) return false;
    flat = flat && in_one_plane(was, is);
    least = std::min(least, std::abs(dot(ni, m.coords[v] - m.coords[u])) / li);
    size = std::max({size, norm(is[1] - is[0]), norm(is[2] - is[0])});
  }
  if (flat) return true;
  const auto of = [&](VertId a, const Facet& f) {
    const Triangle t = shape(a, f);
    return deviation(*reference_, t[0], t[1], t[2], place_near(m, std::array{a, f.x, f.y}));
  };
  Worst worst(facets, [&](const Facet& f) { return of(v, f); });
  bool first = true;
  for (const Facet& f : facets) {
    if (f.x == u || f.y == u) continue;
    const Deviation is = of(u, f);
    if (first && least > std::max(is.allowed, FacetLimits{}.collapse_deviation * size)) return false;
    first = false;
    if (!is_near(is, worst)) return false;
  }
  return true;
}

bool PatchGeometry::allows_ridge_collapse(const TetMesh& m, VertId v, VertId u, VertId w) const {
  if (flat_.allows_ridge_collapse(m, v, u, w)) return true;
  const SurfacePlace at = m.surface_place[v];
  if (!is_edge(at)) return false;
  const Vec3 e = m.coords[w] - m.coords[u], d = m.coords[v] - m.coords[u];
  const double l2 = dot(e, e);
  if (!(l2 > 0) || dot(d, e) <= 0 || dot(d, e) >= l2) return false;
  const double allowed = reference_->allowed_deviation(at);
  const auto off = [&](Vec3 x) { return norm(x - reference_->nearest_on_edges(x, at).x); };
  const Vec3 xu = m.coords[u];
  return norm(cross(e, d)) <= allowed * std::sqrt(l2) && off(xu + 0.25 * e) <= allowed &&
         off(xu + 0.5 * e) <= allowed && off(xu + 0.75 * e) <= allowed;
}

bool PatchGeometry::allows_move(const TetMesh& m, VertId v, Vec3 x,
                                std::span<const std::array<VertId, 3>> facets) const {
  const auto shape = [&](const std::array<VertId, 3>& f) {
    return Triangle{m.coords[f[0]], m.coords[f[1]], m.coords[f[2]]};
  };
  const auto moved = [&](const std::array<VertId, 3>& f) {
    Triangle t = shape(f);
    for (std::size_t i = 0; i < 3; ++i) t[i] = f[i] == v ? x : t[i];
    return t;
  };
  bool flat = true;
  for (const auto& f : facets) {
    const Triangle was = shape(f), is = moved(f);
    // A facet that is folded may turn back by any angle: what counts is how it then is against the surface.
    if (!(dot(area_vector(was), area_vector(is)) > 0)) return false;
    flat = flat && in_one_plane(was, is);
  }
  if (flat) return true;
  const auto of = [&](const Triangle& t, const std::array<VertId, 3>& f) {
    return deviation(*reference_, t[0], t[1], t[2], place_near(m, f));
  };
  Worst worst(facets, [&](const std::array<VertId, 3>& f) { return of(shape(f), f); });
  return std::all_of(facets.begin(), facets.end(), [&](const auto& f) { return is_near(of(moved(f), f), worst); });
}

bool PatchGeometry::allows_swap(const TetMesh& m, VertId a, VertId b, VertId c, VertId d) const {
  using Verts = std::array<VertId, 3>;
  const std::array old{Verts{a, b, c}, Verts{b, a, d}}, after{Verts{d, c, a}, Verts{c, d, b}};
  const auto shape = [&](const Verts& f) { return Triangle{m.coords[f[0]], m.coords[f[1]], m.coords[f[2]]}; };
  bool flat = true;
  for (const Verts& o : old) {
    for (const Verts& n : after) {
      const Vec3 no = area_vector(shape(o)), nn = area_vector(shape(n));
      if (!(dot(no, nn) > min_dot_ * norm(no) * norm(nn))) return false;
      flat = flat && in_one_plane(shape(o), shape(n));
    }
  }
  if (flat) return true;
  const auto of = [&](const Verts& f) {
    const Triangle t = shape(f);
    return deviation(*reference_, t[0], t[1], t[2], place_near(m, f));
  };
  Worst worst(old, of);
  return is_near(of(after[0]), worst) && is_near(of(after[1]), worst);
}

}  // namespace skein
