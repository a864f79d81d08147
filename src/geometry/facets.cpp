// The boundary as the facets that it has.
#include "geometry/facets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/deviation.hpp"

namespace skein {
namespace {

constexpr double kFlat = 1e-9;  ///< relative height up to which facets count as one plane, edges as one line

/// The line through both ends of the ridge at v, if v is on it.
std::optional<Freedom> along_ridge(const TetMesh& m, VertId v, const std::array<VertId, 2>& ends) {
  if (ends[1] == kNoVert) return {};
  const Vec3 first = m.coords[ends[0]], last = m.coords[ends[1]];
  const Vec3 line = normalized(last - first);
  if (norm(cross(line, m.coords[v] - first)) > kFlat * norm(last - first)) return {};
  return Freedom{1, line, {}};
}

/// The plane of the facets, if they have one.
std::optional<Freedom> in_plane(const TetMesh& m, std::span<const std::array<VertId, 3>> facets) {
  Vec3 one, normal;  // of one facet, of all by their areas: what a needle says is next to nothing
  bool first = true;
  for (const auto& k : facets) {
    const Vec3 area = cross(m.coords[k[1]] - m.coords[k[0]], m.coords[k[2]] - m.coords[k[0]]);
    const Vec3 n = normalized(area);
    if (first) one = n;
    first = false;
    if (norm(cross(n, one)) > kFlat * 1e3) return {};
    // Of an internal interface, facets come from both sides.
    normal += dot(n, one) < 0 ? -1.0 * area : area;
  }
  normal = normalized(normal);
  const Vec3 axis = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Freedom free{2, normalized(cross(normal, axis)), {}};
  free.t1 = cross(normal, free.t0);
  return free;
}

}  // namespace

FacetGeometry::FacetGeometry(const FacetLimits& limits, const ReferenceSurface* reference)
    : limits_(limits), min_dot_(std::cos(limits.max_turn * std::numbers::pi / 180)), reference_(reference) {}

BoundaryPoint FacetGeometry::between(const TetMesh& m, VertId a, VertId b, double s, EdgeKind) const {
  return {m.coords[a] + s * (m.coords[b] - m.coords[a])};
}

BoundaryPoint FacetGeometry::middle(const TetMesh& m, VertId a, VertId b, EdgeKind) const {
  const Vec3 xa = m.coords[a], xb = m.coords[b];
  return {{0.5 * (xa.x + xb.x), 0.5 * (xa.y + xb.y), 0.5 * (xa.z + xb.z)}};
}

BoundaryPoint FacetGeometry::project(const TetMesh&, VertId, Vec3 x) const { return {x}; }

double FacetGeometry::distance(const TetMesh&, VertId) const { return 0; }

bool FacetGeometry::allows_move(const TetMesh&, VertId, Vec3, std::span<const std::array<VertId, 3>>) const {
  return true;  // in a plane or along a line
}

std::optional<Freedom> FacetGeometry::freedom(const TetMesh& m, VertId v, const BoundaryStar& star) const {
  if (m.has(v, kRidge)) return along_ridge(m, v, star.ridge_ends);
  return in_plane(m, star.facets);
}

bool FacetGeometry::allows_collapse(const TetMesh& m, VertId v, VertId u, std::span<const Facet> facets) const {
  bool near = false, flat = true;
  for (const Facet& f : facets) {
    if (f.x == u || f.y == u) continue;
    const Vec3 xv = m.coords[v], xu = m.coords[u], xx = m.coords[f.x], xy = m.coords[f.y];
    const Vec3 was = cross(xx - xv, xy - xv), is = cross(xx - xu, xy - xu);
    const double lw = norm(was), li = norm(is);
    if (!(dot(was, is) > min_dot_ * lw * li) || !(li > 0)) return false;
    const double height = std::abs(dot(is, xv - xu)) / li;  // of v over the new facet's plane
    const double size = std::max(norm(xx - xu), norm(xy - xu));
    if (height <= limits_.collapse_deviation * size) near = true;
    if (height > kFlat * size) flat = false;
  }
  return flat || (near && (reference_ == nullptr || stays_near(*reference_, m, v, u, facets)));
}

bool FacetGeometry::allows_ridge_collapse(const TetMesh& m, VertId v, VertId u, VertId w) const {
  // The new ridge edge (u, w) must pass close to v.
  const Vec3 e = m.coords[w] - m.coords[u], d = m.coords[v] - m.coords[u];
  const double l2 = dot(e, e);
  if (!(l2 > 0) || dot(d, e) <= 0 || dot(d, e) >= l2) return false;
  return norm(cross(e, d)) <= limits_.collapse_deviation * l2;
}

bool FacetGeometry::allows_swap(const TetMesh& m, VertId a, VertId b, VertId c, VertId d) const {
  const Vec3 xa = m.coords[a], xb = m.coords[b], x0 = m.coords[c], x1 = m.coords[d];
  const Vec3 old0 = cross(xb - xa, x0 - xa), old1 = cross(x1 - xa, xb - xa);
  const Vec3 new0 = cross(x1 - xa, x0 - xa), new1 = cross(x0 - xb, x1 - xb);
  for (const Vec3& o : {old0, old1}) {
    for (const Vec3& n : {new0, new1}) {
      if (!(dot(o, n) > min_dot_ * norm(o) * norm(n))) return false;
    }
  }
  const Vec3 e = xb - xa;
  const double height = std::abs(volume6(xa, xb, x0, x1)) / std::max(norm(cross(e, x1 - x0)), 1e-300);
  const double size = std::min(norm(e), norm(x1 - x0));
  if (reference_ == nullptr || height <= kFlat * size) return height <= limits_.swap_deviation * size;
  return height <= limits_.swap_deviation * size &&
         swap_stays_near(*reference_, m, std::array{std::array{a, b, c}, std::array{b, a, d}},
                         std::array{std::array{d, c, a}, std::array{c, d, b}});
}

const FacetGeometry& default_geometry() noexcept {
  static const FacetGeometry facets;
  return facets;
}

}  // namespace skein
