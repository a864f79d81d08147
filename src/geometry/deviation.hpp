// How far facets of the mesh are off the reference surface.
#pragma once
#include <array>
#include <span>

#include "geometry/geometry.hpp"
#include "geometry/reference_surface.hpp"

namespace skein {

/// Of one facet, or the worst of several.
struct Deviation {
  double distance = 0;  ///< of the middles of its sides and of its centroid
  double cosine = 1;    ///< between its normal and that of the surface at its centroid, whichever side they show
  double allowed = 0;   ///< by the surface there
};
/// `near`: where one of its vertices is on the surface.
Deviation deviation(const ReferenceSurface& surface, Vec3 a, Vec3 b, Vec3 c, SurfacePlace near);
/// The most useful of these vertices' places for deviation().
SurfacePlace place_near(const TetMesh& m, std::span<const VertId> verts) noexcept;

/// True if the facets that come when v is collapsed onto u are no farther from the surface than it allows, or than the
/// facets that go.
bool stays_near(const ReferenceSurface& surface, const TetMesh& m, VertId v, VertId u, std::span<const Facet> facets);
/// The same when two facets are replaced by two others.
bool swap_stays_near(const ReferenceSurface& surface, const TetMesh& m,
                     std::span<const std::array<VertId, 3>, 2> before, std::span<const std::array<VertId, 3>, 2> after);

}  // namespace skein
