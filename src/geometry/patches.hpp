// PatchGeometry: the boundary lies on the curved patches of a reference surface.
#pragma once
#include "geometry/deviation.hpp"
#include "geometry/facets.hpp"

namespace skein {

/// How far operations may leave the surface.
struct PatchLimits {
  double max_turn = 45;   ///< degrees that an operation may turn a facet's normal
  double max_angle = 25;  ///< degrees between the normals of a facet and of the surface, where it was not more before
};

/// New vertices lie on the patches and on the curves of the features, and vertices move on them. Facets may be as far
/// off as the surface allows (allowed_deviation), or as far as those that they replace. Where the surface is flat, all
/// is as with FacetGeometry, to the bit. @pre the mesh has the column surface_place.
class PatchGeometry final : public Geometry {
 public:
  PatchGeometry(const FacetLimits& flat, const PatchLimits& limits, const ReferenceSurface& reference);
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
  /// The point of the surface for x, a point of the edge (a, b).
  [[nodiscard]] BoundaryPoint lift(const TetMesh& mesh, VertId a, VertId b, Vec3 x, EdgeKind kind) const;
  /// The new facet is good enough by itself, or no worse than the worst of the old ones, which worst() tells.
  template <class Worst>
  [[nodiscard]] bool is_near(const Deviation& is, Worst&& worst) const;

  FacetGeometry flat_;
  double min_dot_, min_cosine_;
  const ReferenceSurface* reference_;
};

}  // namespace skein
