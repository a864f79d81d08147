// TetLocator: finds the tetrahedron of one rank that contains a point, or the nearest one.
#pragma once
#include <array>
#include <vector>

#include "mesh/tet_mesh.hpp"
#include "solution/transfer_boxes.hpp"

namespace skein {

/// A place in a tetrahedron: barycentric weights, sum 1.
struct Place {
  TetId tet = kNoTet;
  std::array<double, 4> weight{};
  double distance2 = kInfinity;  ///< square of the distance of the point asked for; 0 inside
};

/// Copies the coordinates, tetrahedra and neighbours of a mesh and makes a tree of boxes over them. Fast when
/// consecutive tetrahedra are near in space, as after distribute(); correct in any order.
class TetLocator {
 public:
  /// @pre no free slots; tet2face is right.
  explicit TetLocator(const TetMesh& mesh);

  /// The tetrahedron that contains x, to rounding: no barycentric weight below -kTolerance. Walks over faces from
  /// `hint` (kNoTet: none), and uses the tree where the walk ends at a border. False when no tetrahedron contains x.
  /// `hint` becomes the tetrahedron found. Thread-safe.
  bool find(Vec3 x, TetId& hint, Place& place) const noexcept;
  /// The nearest point of the mesh, if its squared distance is at most limit2; otherwise tet is kNoTet. If several
  /// tetrahedra are equally near, any of them. Thread-safe.
  [[nodiscard]] Place nearest(Vec3 x, double limit2) const noexcept;

  [[nodiscard]] const std::array<VertId, 4>& verts(TetId t) const noexcept { return tet2vert_[t]; }
  /// At most `most` boxes that cover all tetrahedra.
  [[nodiscard]] std::vector<Box> boxes(std::size_t most) const { return tree_.level_of_at_most(most); }

  static constexpr double kTolerance = 1e-10;

 private:
  [[nodiscard]] std::array<double, 4> weights(TetId t, Vec3 x) const noexcept;
  [[nodiscard]] Place place_inside(TetId t, Vec3 x, const std::array<double, 4>& rough) const noexcept;
  [[nodiscard]] bool walk(Vec3 x, TetId& t, std::array<double, 4>& w) const noexcept;
  void nearest_in(TetId t, Vec3 x, Place& best) const noexcept;

  IdVector<VertId, Vec3> coords_;
  IdVector<TetId, std::array<VertId, 4>> tet2vert_;
  IdVector<TetId, std::array<FaceId, 4>> tet2face_;
  BoxTree tree_;  ///< a leaf is kLeaf consecutive tetrahedra
};

}  // namespace skein
