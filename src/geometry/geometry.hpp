// Geometry: where vertices of the boundary may be. Asked by every operator that makes, moves or removes one.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// What an edge lies on; decides the class of a new vertex on it.
enum class EdgeKind : std::uint8_t {
  kInside,   ///< no tagged face has it
  kSurface,  ///< an edge of tagged faces, of no feature
  kRidge,    ///< a feature edge of tagged faces
  kLine      ///< a feature edge inside a region
};
/// Of a vertex that is made on an edge of this kind.
constexpr VertClass class_on(EdgeKind kind) noexcept {
  constexpr std::array<VertClass, 4> kClass{VertClass{}, kSurface, kSurface | kRidge, kRidge};
  return kClass[static_cast<std::size_t>(kind)];
}

/// A place for a vertex of the boundary.
struct BoundaryPoint {
  Vec3 x;
  SurfacePlace place = SurfacePlace::kUnknown;  ///< for the column surface_place
};

/// Where a vertex may go: the whole space, a plane or a line through where it is.
struct Freedom {
  int dims = 3;
  Vec3 t0, t1;  ///< orthonormal directions of the plane or line
};

/// A facet (tagged face) at a vertex v: the triangle (v, x, y), counter-clockwise seen from outside.
struct Facet {
  VertId x, y;
  FaceTag tag;
};

/// The boundary round a vertex: its facets, or the two ends of the feature edges at a vertex of a ridge.
struct BoundaryStar {
  std::span<const std::array<VertId, 3>> facets;  ///< as the tetrahedra see them, from both sides where there are two
  std::array<VertId, 2> ridge_ends{kNoVert, kNoVert};
};

/// The surface that the boundary of the mesh stands for. What it answers depends on nothing but its arguments and the
/// coordinates and surface places of the vertices that they name, so both sides of an interface between parts get the
/// same bits. Several threads may ask at once. Calls are per operation on the boundary, never per tetrahedron inside.
class Geometry {
 public:
  Geometry() = default;
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;
  virtual ~Geometry() = default;

  /// The place of a new vertex at the share s of the way from a to b, on an edge of the boundary. @pre 0 < s < 1.
  [[nodiscard]] virtual BoundaryPoint between(const TetMesh& mesh, VertId a, VertId b, double s,
                                              EdgeKind kind) const = 0;
  /// The same for s = 1/2: the same bits also when a and b change places.
  [[nodiscard]] virtual BoundaryPoint middle(const TetMesh& mesh, VertId a, VertId b, EdgeKind kind) const = 0;
  /// The place on the geometry for vertex v of the boundary when it is to go to x.
  [[nodiscard]] virtual BoundaryPoint project(const TetMesh& mesh, VertId v, Vec3 x) const = 0;
  /// How far vertex v of the boundary is off the geometry.
  [[nodiscard]] virtual double distance(const TetMesh& mesh, VertId v) const = 0;
  /// Where a vertex of the boundary may move; nothing: it must stay. @pre v is no corner, not required, not frozen.
  [[nodiscard]] virtual std::optional<Freedom> freedom(const TetMesh& mesh, VertId v,
                                                       const BoundaryStar& star) const = 0;
  /// The facets at v may be replaced by facets at u: (u, x, y) for each of `facets` that does not have u.
  [[nodiscard]] virtual bool allows_collapse(const TetMesh& mesh, VertId v, VertId u,
                                             std::span<const Facet> facets) const = 0;
  /// The feature edges (u, v) and (v, w) may be replaced by (u, w).
  [[nodiscard]] virtual bool allows_ridge_collapse(const TetMesh& mesh, VertId v, VertId u, VertId w) const = 0;
  /// The vertex v of the boundary may move to x. `facets`: those at it, as they are.
  [[nodiscard]] virtual bool allows_move(const TetMesh& mesh, VertId v, Vec3 x,
                                         std::span<const std::array<VertId, 3>> facets) const = 0;
  /// The facets (a, b, c) and (b, a, d) may be replaced by (d, c, a) and (c, d, b).
  [[nodiscard]] virtual bool allows_swap(const TetMesh& mesh, VertId a, VertId b, VertId c, VertId d) const = 0;
};

}  // namespace skein
