// Sampling the distance of facets to the reference surface.
#include "geometry/deviation.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

Deviation deviation(const ReferenceSurface& surface, Vec3 a, Vec3 b, Vec3 c, SurfacePlace near) {
  Deviation out;
  const auto off = [&](Vec3 x, SurfacePlace from) {
    const SurfacePoint p = surface.below(x, from);
    const Vec3 d = x - p.x;
    out.distance =
        std::max(out.distance, surface.shape() == SurfaceShape::kFacets ? norm(d) : std::abs(dot(d, p.direction)));
    return p;
  };
  const SurfacePoint centre = off((1.0 / 3) * (a + b + c), near);
  const SurfacePlace at = is_triangle(near) ? near : centre.place;
  for (const Vec3 x : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)}) off(x, at);
  out.cosine = std::abs(dot(normalized(cross(b - a, c - a)), centre.direction));
  out.allowed = surface.allowed_deviation(centre.place);
  return out;
}

SurfacePlace place_near(const TetMesh& m, std::span<const VertId> verts) noexcept {
  for (const VertId v : verts) {
    if (!m.surface_place.empty() && is_triangle(m.surface_place[v])) return m.surface_place[v];
  }
  return SurfacePlace::kUnknown;
}

bool stays_near(const ReferenceSurface& surface, const TetMesh& m, VertId v, VertId u, std::span<const Facet> facets) {
  double worst = -1;  // of the facets that go, once it is asked for
  const auto of = [&](VertId a, const Facet& f) {
    return deviation(surface, m.coords[a], m.coords[f.x], m.coords[f.y], place_near(m, std::array{a, f.x, f.y}));
  };
  for (const Facet& f : facets) {
    if (f.x == u || f.y == u) continue;
    const Deviation is = of(u, f);
    if (is.distance <= is.allowed) continue;
    if (worst < 0) {
      for (const Facet& old : facets) worst = std::max(worst, of(v, old).distance);
    }
    if (is.distance > worst) return false;
  }
  return true;
}

bool swap_stays_near(const ReferenceSurface& surface, const TetMesh& m,
                     std::span<const std::array<VertId, 3>, 2> before,
                     std::span<const std::array<VertId, 3>, 2> after) {
  const auto of = [&](const std::array<VertId, 3>& f) {
    return deviation(surface, m.coords[f[0]], m.coords[f[1]], m.coords[f[2]], place_near(m, f));
  };
  const Deviation first = of(after[0]), second = of(after[1]);
  if (first.distance <= first.allowed && second.distance <= second.allowed) return true;
  return std::max(first.distance, second.distance) <= std::max(of(before[0]).distance, of(before[1]).distance);
}

}  // namespace skein
