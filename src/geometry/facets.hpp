// FacetGeometry: the boundary stays on the facets that it has.
#pragma once
#include "geometry/geometry.hpp"

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
  explicit FacetGeometry(const FacetLimits& limits = {});
  [[nodiscard]] Vec3 between(const TetMesh& mesh, VertId a, VertId b, double s, EdgeKind kind) const override;
  [[nodiscard]] Vec3 middle(const TetMesh& mesh, VertId a, VertId b, EdgeKind kind) const override;
  [[nodiscard]] Vec3 project(const TetMesh& mesh, VertId v, Vec3 x) const override;
  [[nodiscard]] std::optional<Freedom> freedom(const TetMesh& mesh, VertId v, const BoundaryStar& star) const override;
  [[nodiscard]] bool allows_collapse(const TetMesh& mesh, VertId v, VertId u,
                                     std::span<const Facet> facets) const override;
  [[nodiscard]] bool allows_ridge_collapse(const TetMesh& mesh, VertId v, VertId u, VertId w) const override;
  [[nodiscard]] bool allows_swap(const TetMesh& mesh, VertId a, VertId b, VertId c, VertId d) const override;

 private:
  FacetLimits limits_;
  double min_dot_;  ///< cosine of max_turn
};

/// One with the limits as they are unless told otherwise.
const FacetGeometry& default_geometry() noexcept;

}  // namespace skein
