// FacetGeometry: the boundary stays on the facets that it has.
#pragma once
#include "geometry/geometry.hpp"
#include "geometry/reference_surface.hpp"

namespace skein {

/// How far operations may leave the facets that they replace.
struct FacetLimits {
  double max_turn = 15;               ///< degrees that an operation may turn a facet's normal
  double swap_deviation = 0.01;       ///< of a swap, relative to the edge
  double collapse_deviation = 0.002;  ///< of a collapse, relative to the edge; smaller, since many of them add up
};

/// New vertices lie on the straight edge, vertices move in the plane of their facets or along a straight ridge, and
/// those where the boundary bends stay where they are.
class FacetGeometry final : public Geometry {
 public:
  /// `reference` (or null; not owned): the facets of the first mesh, from which those that a collapse leaves may be as
  /// far off as it allows (allowed_deviation), or as far as those that were there.
  explicit FacetGeometry(const FacetLimits& limits = {}, const ReferenceSurface* reference = nullptr);
  [[nodiscard]] BoundaryPoint between(const TetMesh& mesh, VertId a, VertId b, double s, EdgeKind kind) const override;
  [[nodiscard]] BoundaryPoint middle(const TetMesh& mesh, VertId a, VertId b, EdgeKind kind) const override;
  [[nodiscard]] BoundaryPoint project(const TetMesh& mesh, VertId v, Vec3 x) const override;
  [[nodiscard]] double distance(const TetMesh& mesh, VertId v) const override;
  [[nodiscard]] std::optional<Freedom> freedom(const TetMesh& mesh, VertId v, const BoundaryStar& star) const override;
  [[nodiscard]] bool allows_collapse(const TetMesh& mesh, VertId v, VertId u,
                                     std::span<const Facet> facets) const override;
  [[nodiscard]] bool allows_ridge_collapse(const TetMesh& mesh, VertId v, VertId u, VertId w) const override;
  [[nodiscard]] bool allows_move(const TetMesh& mesh, VertId v, Vec3 x,
                                 std::span<const std::array<VertId, 3>> facets) const override;
  [[nodiscard]] bool allows_swap(const TetMesh& mesh, VertId a, VertId b, VertId c, VertId d) const override;

 private:
  FacetLimits limits_;
  double min_dot_;  ///< cosine of max_turn
  const ReferenceSurface* reference_;
};

/// One with the limits as they are unless told otherwise.
const FacetGeometry& default_geometry() noexcept;

}  // namespace skein
