// Removal of a vertex: a neighbour is reinserted into its ball.
#pragma once
#include <vector>

#include "geometry/geometry.hpp"
#include "kernel/cavity.hpp"
#include "kernel/objective.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Collapses vertex v onto its neighbour u: the ball of v is coned from u. Refused when v may not go (corner, required,
/// frozen), when a vertex of a feature edge would leave it or a surface vertex its patch, when tetrahedra, facets or
/// feature edges would come to lie on one another that do not now (the link condition [Dey1999] for the volume, its
/// surfaces and its lines), when the geometry does not allow the new facets, a new edge gets longer than `max_length`,
/// or the objective is not met.
class Collapser {
 public:
  Collapser(Part& part, Cavity& cavity) : part_(&part), cavity_(&cavity) {}
  /// `at` is a tetrahedron with both of them. Objective: KeepFloor, RaiseWorst, LowerStrain (of the edges that come
  /// against those that go) or LowerSum.
  template <class Objective>
  bool collapse(VertId v, VertId u, TetId at, double max_length, const Objective& objective);

 private:
  /// The edges from u have less strain than those from v, whose ball is in the cavity.
  [[nodiscard]] bool lowers_strain(VertId v, VertId u, TetId at, double strain_share);
  [[nodiscard]] bool may_leave(VertId v, VertId u) const noexcept;
  void collect_facets(VertId v);
  /// The geometry allows the new facets, and the surface stays as it is connected.
  [[nodiscard]] bool surface_allows(VertId v, VertId u);
  /// v and u have no common neighbours on the surface but those of the facets that they share, and no facet would come
  /// to lie on another.
  [[nodiscard]] bool links_meet_in_facets(VertId v, VertId u);
  /// Some facet at v is (v, x, y).
  [[nodiscard]] bool has_facet(VertId x, VertId y) const noexcept;
  /// Lists the other ends of the feature edges at v, whose ball is in the cavity.
  void list_feature_ends(VertId v);
  /// The feature edges at v may follow it to u.
  [[nodiscard]] bool features_allow(VertId v, VertId u) const;
  /// Of the tetrahedra at v, all of which the cavity must have where bodies touch: one of each set that hangs together.
  template <class Fits>
  bool add_fans(VertId v, VertId u, Fits&& fits);
  /// The ball of v into the cavity; false, halfway, when a new edge from u would be longer than max_length.
  bool gather_within(VertId v, VertId u, TetId at, double max_length);
  [[nodiscard]] bool facets_can_move(VertId v, VertId u) const noexcept;
  bool cone(VertId v, VertId u, double floor_q3);
  void move_features(VertId v, VertId u);
  /// Facets and features follow, then the cavity is committed.
  void commit(VertId v, VertId u);

  Part* part_;
  Cavity* cavity_;
  std::vector<Facet> facets_;
  std::vector<TetId> ball_u_;
  std::vector<VertId> feature_ends_;
  Shell shell_;
};

}  // namespace skein
