// The surface that the boundary of the mesh stands for: the triangles of the first mesh, flat or as curved patches.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec3.hpp"
#include "geometry/surface_tree.hpp"
#include "mesh/surface_place.hpp"

namespace skein {

/// How the surface runs between the vertices of its triangles.
enum class SurfaceShape : std::uint8_t {
  kFacets,  ///< flat triangles, straight edges
  kPatches  ///< curved: through the vertices, with continuous normals but for the feature edges
};

/// The triangles of a boundary and its feature edges. Indices count from 0.
struct SurfaceInput {
  using Triangle = SurfaceTree::Triangle;
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;                 ///< of either orientation, neighbours in one patch alike
  std::vector<std::int32_t> patch;                 ///< per triangle
  std::vector<std::array<std::int32_t, 2>> edges;  ///< feature edges on the triangles, each once
  std::vector<std::uint8_t> is_corner;             ///< per point: feature edges end, branch or bend here
};

/// A point of the surface.
struct SurfacePoint {
  Vec3 x;
  SurfacePlace place = SurfacePlace::kUnknown;
  Vec3 direction{};   ///< unit normal of a point on a triangle, unit tangent of one on a feature edge
  bool flat = false;  ///< the triangle or edge there is flat or straight, with all that it runs into smoothly
};

/// Immutable. Several threads may ask at once; answers depend on nothing but the arguments.
///
/// Between vertices, kPatches has Nielson's side-vertex interpolant [Nielson1987; the chapter 35.4.7.1] over each
/// triangle: it meets the vertices, their normals, and along each side one cubic and its normals that both triangles at
/// the side share, so that the surface has no kinks but at feature edges. These are cubics themselves. Normals are
/// those of quadrics through the triangles round a vertex that no feature edge separates (one-sided at features),
/// tangents those of circles through neighbours on the feature. Triangles that are in one plane with all their
/// neighbours stay exactly flat.
class ReferenceSurface {
 public:
  ReferenceSurface(SurfaceInput input, SurfaceShape shape);

  /// The point of the surface that is nearest to x, looking round `from` first: the same sheet is kept where two are
  /// near each other. With `from` unknown, the nearest of all.
  [[nodiscard]] SurfacePoint nearest(Vec3 x, SurfacePlace from) const { return find(x, from, kExactly); }
  /// The nearest point among the triangles of this patch.
  [[nodiscard]] SurfacePoint nearest_of_patch(Vec3 x, std::int32_t patch) const;
  /// A point of the surface next to x, off the nearest one sidewards by little against the triangle: quicker, and as
  /// good for vertices, which may be anywhere on the surface.
  [[nodiscard]] SurfacePoint near(Vec3 x, SurfacePlace from) const { return find(x, from, kRoughly); }
  /// The height of x over the surface at the foot of the perpendicular to the facet: the distance but for terms of
  /// higher order. Quickest.
  [[nodiscard]] SurfacePoint below(Vec3 x, SurfacePlace from) const { return find(x, from, kAtOnce); }
  /// How far x is off the surface or feature edge of `from`. Where a patch is flat, off its plane: its points are no
  /// places of x, as its curved sides move them.
  [[nodiscard]] double distance(Vec3 x, SurfacePlace from) const;
  /// The same on the feature edges; `from` unknown: the nearest of all edges, which takes long.
  [[nodiscard]] SurfacePoint nearest_on_edges(Vec3 x, SurfacePlace from) const;
  /// A triangle of the surface at one of its points, the feature edge of a point on a feature, unknown at a corner.
  [[nodiscard]] SurfacePlace place_of_point(std::int32_t point) const noexcept {
    return places_[static_cast<std::size_t>(point)];
  }
  /// How far a facet at this place may be off the surface, as limit_deviation() has set it; without it, as far as it
  /// likes.
  [[nodiscard]] double allowed_deviation(SurfacePlace place) const noexcept;
  /// Sets it for each smooth piece (triangles that no feature edge separates): `share` of its bounding box, not above
  /// `most` of any of its triangles, nor (unless 0) above `narrow_share` of its area over the length of its rim, so
  /// that a narrow piece keeps its area when its rim gets coarser. At a feature edge, the least of the pieces at it.
  void limit_deviation(double share, double narrow_share, std::span<const double> most);

  [[nodiscard]] SurfaceShape shape() const noexcept { return shape_; }
  [[nodiscard]] const SurfaceInput& input() const noexcept { return in_; }
  /// Of triangle t at its corner k.
  [[nodiscard]] Vec3 normal(std::int32_t t, std::size_t k) const noexcept { return tri(t).normal[k]; }
  /// The point of triangle t at these barycentric coordinates (none negative, sum 1).
  [[nodiscard]] Vec3 evaluate(std::int32_t t, const std::array<double, 3>& w) const noexcept;
  /// The unit normal there.
  [[nodiscard]] Vec3 normal_at(std::int32_t t, const std::array<double, 3>& w) const noexcept;
  /// What area and volume gain when triangle t becomes its curved patch, by sampling. The volume is that of the cone to
  /// the first point of the surface, positive where its normal points away: to be added up over a closed surface.
  struct Gain {
    double area = 0, volume = 0;
  };
  [[nodiscard]] Gain gain(std::int32_t t) const noexcept;
  /// Length of a feature edge along its curve, by sampling, and straight.
  [[nodiscard]] double edge_length(std::int32_t e) const noexcept;
  [[nodiscard]] double chord(std::int32_t e) const noexcept { return norm(curve(e).x1 - curve(e).x0); }

 private:
  /// A triangle with what its patch is made from. Side i is opposite corner i, from corner i+1 to corner i+2.
  struct Patch {
    std::array<Vec3, 3> x, normal;
    std::array<std::array<Vec3, 2>, 3> derivative;      ///< of the cubic of each side, at its ends
    std::array<std::int32_t, 3> neighbour{-1, -1, -1};  ///< over each side; -1: a feature edge is between
    std::array<std::int32_t, 3> curve{-1, -1, -1};      ///< the feature edge that each side is
    Vec3 facet_normal;
    std::int32_t piece = 0;
    bool flat = true;      ///< the patch is in the plane of its corners
    bool straight = true;  ///< so are its sides: all of it is the triangle
  };
  /// Change of barycentric coordinates with which the iteration to the nearest point ends.
  static constexpr double kExactly = 1e-13, kRoughly = 1e-3, kAtOnce = 1;
  struct Curve {
    Vec3 x0, x1, d0, d1;
    std::array<std::int32_t, 2> next{-1, -1};  ///< the edges beyond its ends; -1: a corner
    bool straight = true;
  };
  [[nodiscard]] const Patch& tri(std::int32_t t) const noexcept { return patches_[static_cast<std::size_t>(t)]; }
  [[nodiscard]] const Curve& curve(std::int32_t e) const noexcept { return curves_[static_cast<std::size_t>(e)]; }
  [[nodiscard]] bool walk(Vec3 x, std::int32_t& t, std::array<double, 3>& w) const noexcept;
  [[nodiscard]] SurfacePoint find(Vec3 x, SurfacePlace from, double settled) const;
  [[nodiscard]] SurfacePoint settle(Vec3 x, std::int32_t t, std::array<double, 3> w, double settled) const noexcept;
  [[nodiscard]] std::int32_t search(Vec3 x, SurfacePlace from) const noexcept;
  friend class SurfaceBuilder;

  SurfaceInput in_;
  SurfaceShape shape_;
  std::vector<Patch> patches_;
  std::vector<Curve> curves_;
  std::vector<SurfacePlace> places_;  ///< per point
  std::vector<double> limit_;         ///< per piece
  std::vector<double> edge_limit_;    ///< per feature edge
  double least_limit_ = 0;
  SurfaceTree tree_;
};

}  // namespace skein
