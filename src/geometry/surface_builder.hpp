// What the curved patches of a reference surface are made from: neighbours, smooth pieces, normals, tangents.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/reference_surface.hpp"

namespace skein {

/// Fills in a ReferenceSurface, step by step in the order below.
class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(ReferenceSurface& surface) : s_(surface) {}
  void build();

 private:
  /// A side of a triangle with its ends in ascending order.
  struct Side {
    std::int32_t a, b, triangle, side;
  };
  /// Triangles meet over sides that no feature edge has and that exactly two triangles have.
  void find_neighbours();
  /// Neighbours get the same orientation; where that cannot be (a band with one side), they are parted.
  void orient_pieces();
  void place_points();
  void find_normals();
  void find_curves();
  void find_flat();
  void find_sides();

  void list_around_points();
  [[nodiscard]] std::vector<std::int32_t> fan_of(std::int32_t t, std::int32_t point) const;
  [[nodiscard]] Vec3 mean_normal(const std::vector<std::int32_t>& fan, std::int32_t point, bool& flat) const;
  /// A feature edge or a border is at the point, between the first and the last triangle of the fan.
  [[nodiscard]] bool is_open(const std::vector<std::int32_t>& fan, std::int32_t point) const;
  [[nodiscard]] bool is_flat_round(const std::vector<std::int32_t>& fan, int layers) const;
  /// With as many layers of neighbours.
  [[nodiscard]] std::vector<std::int32_t> triangles_round(const std::vector<std::int32_t>& fan, int layers) const;
  [[nodiscard]] std::vector<Vec3> points_round(const std::vector<std::int32_t>& fan, int layers) const;
  void flip(std::int32_t t);
  [[nodiscard]] std::size_t corner(std::int32_t t, std::int32_t point) const;
  [[nodiscard]] Vec3 x(std::int32_t point) const { return s_.in_.points[static_cast<std::size_t>(point)]; }
  [[nodiscard]] const SurfaceInput::Triangle& verts(std::int32_t t) const {
    return s_.in_.triangles[static_cast<std::size_t>(t)];
  }
  [[nodiscard]] ReferenceSurface::Patch& patch(std::int32_t t) { return s_.patches_[static_cast<std::size_t>(t)]; }
  [[nodiscard]] const ReferenceSurface::Patch& patch(std::int32_t t) const {
    return s_.patches_[static_cast<std::size_t>(t)];
  }
  [[nodiscard]] std::int32_t count() const noexcept { return static_cast<std::int32_t>(s_.in_.triangles.size()); }
  /// The feature edge between two points, -1: none.
  [[nodiscard]] std::int32_t feature(std::int32_t a, std::int32_t b) const;
  /// The first point along the feature beyond the end of edge e that is as far away as `least`, or the last one.
  [[nodiscard]] std::int32_t point_along(std::size_t e, std::size_t end, double least) const;
  /// Tangent of the feature curve at the end of edge e (0 or 1), pointing along the edge.
  [[nodiscard]] Vec3 tangent(std::size_t e, std::size_t end) const;

  ReferenceSurface& s_;
  std::vector<std::array<std::int32_t, 3>> sorted_edges_;  ///< lower end, higher end, index
  std::vector<std::int32_t> first_, around_;               ///< triangles at each point
};

}  // namespace skein
