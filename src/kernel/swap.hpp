// Edge swapping over the skew polygon (dynamic programming) and face swapping.
#pragma once
#include <vector>

#include "kernel/cavity.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Swaps that raise the worst quality of the elements they replace.
class Swapper {
 public:
  static constexpr int kMaxRing = Cavity::kMaxRing;
  Swapper(Part& part, Cavity& cavity) : part_(&part), cavity_(&cavity) {}

  /// Removes edge (a, b) of t by the best triangulation of its skew polygon (Klincsek's dynamic programming: the worst
  /// new element as good as can be), if that is better than the shell by the factor `gain` in Q^3. Surface edges inside
  /// one flat patch are swapped with their surface triangles. Not more than `max_ring` vertices round the edge.
  bool edge(TetId t, VertId a, VertId b, int max_ring = kMaxRing, double gain = 1.05);
  /// The same for an edge that is too long or too short: the new ones together have less strain, and no element is
  /// worse that is below the floor.
  bool edge_to_relax(TetId t, VertId a, VertId b, double floor_q3);
  /// The same for the least sum of inverse_sixth_power() over the elements; none is worse that is below the floor.
  bool edge_to_reduce_sum(TetId t, VertId a, VertId b, double floor_q3);
  /// Swaps one of the edges of t with at most max_ring vertices round it; with `remember`, refusals are kept
  /// (Part::refused) and not tried again.
  bool any_edge(TetId t, int max_ring, bool remember);
  /// Swaps one of the edges or faces of t.
  bool any(TetId t);
  /// Replaces the two tetrahedra at a face by three round a new edge, if that is better.
  bool face(FaceId f, double gain = 1.05);
  /// Of the edge that was tried last; cut off where it was too large.
  [[nodiscard]] const Shell& shell() const noexcept { return shell_; }

 private:
  /// Gathers the shell; false if the edge must stay.
  bool gather(TetId t, VertId a, VertId b, int max_ring);
  [[nodiscard]] double worst_of_shell() const noexcept;
  /// Swaps the gathered edge for the best triangulation if all that is made is better than bound_.
  bool make();
  /// Makes the triangulation that split_ tells, if all elements are better than bound_.
  bool make_triangles();
  bool surface_swap_allowed();
  /// The edge between two ring vertices exists already, or has not more strain than max_strain_.
  [[nodiscard]] bool may_connect(int i, int j) const noexcept;
  double best_triangulation(int ring);
  /// The same with the least sum of inverse_sixth_power() among those whose elements are all better than bound_;
  /// returns that sum.
  double lightest_triangulation(int ring);
  /// Lists the triangles of the polygon between ring vertices i and j; false if one of their tetrahedra is not good
  /// enough after all.
  bool list_triangles(int i, int j);
  /// Makes the swap of a surface edge, with its surface triangles.
  void swap_with_walls(int ring);

  Part* part_;
  Cavity* cavity_;
  Shell shell_;
  std::array<std::array<double, kMaxRing>, kMaxRing> best_;
  std::array<std::array<int, kMaxRing>, kMaxRing> split_;
  std::vector<RingTriangle> triangles_;
  double bound_ = 0;
  double max_strain_ = kAnyStrain;
  static constexpr double kAnyStrain = 1e300;
};

}  // namespace skein
