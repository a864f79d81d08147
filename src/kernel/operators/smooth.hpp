// Moving a vertex so that its elements or its edges get better.
#pragma once
#include <span>
#include <vector>

#include "geometry/geometry.hpp"
#include "kernel/cone.hpp"
#include "kernel/objective.hpp"
#include "kernel/part.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Moves vertices; the metric at the new place is interpolated (Part::anchors). Where a vertex of the boundary may go
/// is told by the geometry; corners, required and frozen vertices stay.
class Smoother {
 public:
  explicit Smoother(Part& part) : part_(&part) {}
  /// Moves v if the objective is met at some place that is tried:
  /// - SmoothBall: damped Newton steps to the minimum of the sum of 1/Q^3 over the ball; with Smoothing::kSprings the
  ///   step comes from springs and counts under the same conditions;
  /// - RaiseWorst: steps along the axes of the metric; the best one is taken. For where the metric turns within an
  ///   element, and the model of the Newton step, whose metric is constant, points elsewhere;
  /// - LowerSum: along the axes of the metric and to the minimum of parabolas through what is found there: the same for
  ///   the sum of Q^-6;
  /// - ToSurface: onto the geometry, or as far on the way as the elements allow;
  /// - LowerStrain: Gauss-Newton on the logarithms of the lengths of its edges, led by those farthest from 1.
  template <class Objective>
  bool move(VertId v, const Objective& objective);
  /// Makes the balls of all vertices at once, for many moves of a mesh whose topology does not change until drop_index.
  void index_balls();
  void drop_index() noexcept;
  /// With an index: ask for the tetrahedra that move(v) will read, some moves ahead, and, when these are there, for
  /// their vertices.
  void fetch_ball(VertId v) const noexcept;
  void fetch_vertices(VertId v) const noexcept;

 private:
  /// The elements at a vertex.
  struct Ball {
    double sum = 0, low = 1;  ///< of 1/Q^3; the least Q^3
    Freedom free;
  };
  /// A place that v may go to, with what belongs to it.
  struct Place {
    Vec3 x;
    SymTensor log_m;
    VertMetric m;
    SurfacePlace on = SurfacePlace::kUnknown;  ///< of a vertex of the boundary
  };
  /// Ball and cone of v; false if it may not move.
  bool gather(VertId v, Ball& ball);
  /// Of a vertex of the boundary; false if it may not move.
  bool find_freedom(VertId v, Freedom& free);
  /// Notes the facets at v of the tetrahedron opposite `at` in star_; false if one is required.
  bool note_facets(VertId v, FaceId at);
  /// Notes the ends of the feature edges at v among these vertices; false if there are more than two.
  template <std::size_t N>
  bool note_ridge_ends(VertId v, const std::array<VertId, N>& verts);

  /// Looks for the place with the best value of the objective; the cone then has the qualities there, if true.
  bool search(VertId v, const Ball& ball, const SmoothBall& objective, Place& best);
  bool search(VertId v, const Ball& ball, const RaiseWorst& objective, Place& best);
  bool search(VertId v, const Ball& ball, const LowerSum& objective, Place& best);
  bool search(VertId v, const Ball& ball, const LowerStrain& objective, Place& best);
  bool search(VertId v, const Ball& ball, const ToSurface& objective, Place& best);

  /// The place at x(v) + step, on the geometry; false beyond the ball.
  [[nodiscard]] bool find_place(VertId v, Vec3 step, Place& place);
  /// Q^3 of the ball with its vertex at that place (Cone::judge), as Part::quality_measure wants it. What is below the
  /// bound may be less still.
  double judge(const Place& place, double bound);
  void put(VertId v, const Place& place);
  /// Lists the neighbours of v in link_; returns how many.
  std::size_t list_link(VertId v);
  [[nodiscard]] Vec3 strain_step(VertId v, std::size_t links, const Freedom& free, double& strain) const;
  /// `gain`: the relative decrease of the sum that the step promises.
  [[nodiscard]] Vec3 newton_step(VertId v, const Freedom& f, double& gain);
  /// Towards where springs of metric length 1 along the edges at v are in balance (the chapter's mesh cosmetics).
  [[nodiscard]] Vec3 spring_step(VertId v, const Freedom& f) const;
  /// The log-metric at x(v) + step; false beyond the ball.
  [[nodiscard]] bool interpolate(VertId v, Vec3 step, SymTensor& log_m);
  /// The same from the anchor of v; false also when the anchor cannot see the place from inside the ball.
  [[nodiscard]] bool interpolate_from_anchor(VertId v, Vec3 x, SymTensor& log_m);
  void mark_changed(VertId v);
  bool find_ball(VertId v);
  [[nodiscard]] std::span<const FaceId> indexed_ball(VertId v) const noexcept;

  Part* part_;
  Cone cone_;
  std::vector<FaceId> ball_;                   ///< the faces opposite the vertex at hand
  std::vector<TetId> tets_;                    ///< scratch
  std::vector<VertId> link_;                   ///< scratch: the neighbours of a vertex
  std::vector<std::array<VertId, 3>> facets_;  ///< of the vertex at hand, if it is on the boundary
  BoundaryStar star_;
  std::vector<std::int32_t> first_;  ///< of balls_, per vertex and one more; empty without an index
  std::vector<FaceId> balls_;
};

}  // namespace skein
