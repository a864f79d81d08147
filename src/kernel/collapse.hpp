// Removal of a vertex: a neighbour is reinserted into its ball.
#pragma once
#include <vector>

#include "kernel/cavity.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Collapses vertex v onto its neighbour u: the ball of v is coned from u. Refused when v may not go (corner, required,
/// frozen), when a ridge vertex would leave its ridge or a surface vertex its patch, when an element falls below the
/// floor, a new edge gets longer than `max_length`, or a curved surface would change too much.
class Collapser {
 public:
  Collapser(Part& part, Cavity& cavity) : part_(&part), cavity_(&cavity) {}
  /// `at` is a tetrahedron with both of them.
  bool collapse(VertId v, VertId u, TetId at, double max_length, double floor_q3);
  /// The same, but only if the worst element of the ball gets better by the factor `gain` in Q^3.
  bool collapse_to_improve(VertId v, VertId u, TetId at, double max_length, double gain = 1.2);
  /// The same, but only if the strain of the edges that go is more than that of those that come, and no element gets
  /// worse that is below the floor.
  bool collapse_to_relax(VertId v, VertId u, TetId at, double max_length, double floor_q3);
  /// The same, but only if the sum of inverse_sixth_power() over the elements falls, and no element gets worse that is
  /// below the floor.
  bool collapse_to_reduce_sum(VertId v, VertId u, TetId at, double max_length, double floor_q3);

 private:
  struct Facet {
    VertId x, y;  ///< triangle (v, x, y), counter-clockwise from outside
    FaceTag tag;
  };
  /// `wanted` is asked when the ball is in the cavity, `better` when all that is new is proposed.
  template <class Wanted, class Floor, class Better>
  bool attempt(VertId v, VertId u, TetId at, double max_length, Wanted&& wanted, Floor&& floor_of_old_min,
               Better&& better);
  /// The edges from u have less strain than those from v, whose ball is in the cavity.
  [[nodiscard]] bool relaxes(VertId v, VertId u, TetId at);
  [[nodiscard]] bool may_leave(VertId v, VertId u) const noexcept;
  void collect_facets(VertId v);
  [[nodiscard]] bool surface_allows(VertId v, VertId u);
  [[nodiscard]] bool ridge_allows(VertId v, VertId u);
  /// The ball of v into the cavity; false, halfway, when a new edge from u would be longer than max_length.
  bool gather_within(VertId v, VertId u, TetId at, double max_length);
  [[nodiscard]] bool facets_can_move(VertId v, VertId u) const noexcept;
  bool cone(VertId v, VertId u, double floor_q3);
  void move_features(VertId v, VertId u);

  Part* part_;
  Cavity* cavity_;
  std::vector<Facet> facets_;
  std::vector<TetId> ball_u_;
  Shell shell_;
};

}  // namespace skein
