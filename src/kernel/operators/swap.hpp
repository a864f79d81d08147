// Edge swapping over the skew polygon (dynamic programming) and face swapping.
#pragma once
#include <vector>

#include "geometry/geometry.hpp"
#include "kernel/cavity.hpp"
#include "kernel/objective.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Swaps of edges and faces. (Skew polygon: the chapter [35.3.1]; its best triangulation: [Klincsek1980].)
class Swapper {
 public:
  static constexpr int kMaxRing = Cavity::kMaxRing;
  Swapper(Part& part, Cavity& cavity) : part_(&part), cavity_(&cavity) {}

  /// Removes edge (a, b) of t by the best triangulation of its skew polygon, if the objective is met. Best is the one
  /// whose worst new element is as good as can be (RaiseWorst; LowerStrain, among those whose new edges have little
  /// enough strain), or whose sum of Q^-6 is least (LowerSum). Surface edges inside one patch are swapped with their
  /// facets where the geometry allows. Not more than `max_ring` vertices round the edge.
  template <class Objective>
  bool edge(TetId t, VertId a, VertId b, const Objective& objective, int max_ring = kMaxRing);
  /// Which edges of a tetrahedron any_edge tries.
  enum class Try { kAll, kNotRefused };
  /// Swaps one of the edges of t with at most max_ring vertices round it; with kNotRefused, refusals are kept
  /// (Part::refused) and not tried again.
  bool any_edge(TetId t, const RaiseWorst& objective, int max_ring, Try which);
  /// Swaps one of the edges or faces of t.
  bool any(TetId t, const RaiseWorst& objective);
  /// Replaces the two tetrahedra at a face by three round a new edge.
  bool face(FaceId f, const RaiseWorst& objective);
  /// Of the edge that was tried last; cut off where it was too large.
  [[nodiscard]] const Shell& shell() const noexcept { return shell_; }

 private:
  /// Gathers the shell; false if the edge must stay.
  bool gather(TetId t, VertId a, VertId b, int max_ring);
  [[nodiscard]] double worst_of_shell() const noexcept;
  [[nodiscard]] double sum_of_shell() const noexcept;
  /// Makes the triangulation that split_ tells, if all elements are better than bound_.
  bool make_triangles();
  bool surface_swap_allowed();
  /// Vertices of the ring have an edge that no tetrahedron of the shell has.
  [[nodiscard]] bool are_joined_elsewhere(VertId a, VertId b);
  /// The edge between two ring vertices exists already, or has less strain than max_strain_.
  [[nodiscard]] bool may_connect(int i, int j) const noexcept;
  /// The best score of all triangulations of the ring by triangles (i, k, j) that may_use allows; split_ tells which.
  template <class Score, class MayUse>
  double best_triangulation(int ring, MayUse&& may_use);
  /// Lists the triangles of the polygon between ring vertices i and j; false if one of their tetrahedra is not good
  /// enough after all.
  bool list_triangles(int i, int j);
  /// Makes the swap of a surface edge, with its facets.
  void swap_with_walls(int ring);

  Part* part_;
  Cavity* cavity_;
  Shell shell_;
  std::array<std::array<double, kMaxRing>, kMaxRing> best_;
  std::array<std::array<int, kMaxRing>, kMaxRing> split_;
  std::vector<RingTriangle> triangles_;
  std::vector<TetId> ball_;
  double bound_ = 0;       ///< Q^3 that every new element must exceed
  double max_strain_ = 0;  ///< of a new edge, with LowerStrain
};

}  // namespace skein
