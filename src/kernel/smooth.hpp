// Moving a vertex so that its elements get better.
#pragma once
#include <span>
#include <vector>

#include "kernel/cone.hpp"
#include "kernel/part.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Moves vertices to the minimum of the sum of 1/Q^3 over their ball by damped Newton steps (the sum is led by the
/// worst element and smooth); a step counts only if that sum, with the metric interpolated at the new place, gets
/// smaller and the worst element does not fall below what it was, or below a good quality. Vertices of flat patches
/// move in their plane, those of straight ridges along them, corners and frozen vertices stay. With
/// KernelOptions::springs the steps come from springs, and count under the same conditions.
class Smoother {
 public:
  explicit Smoother(Part& part) : part_(&part) {}
  /// Tries the full step, then up to tries - 1 shorter ones; in a converged mesh these hardly ever help.
  bool move(VertId v, int tries = 1);
  /// Moves v so that the strain of its edges becomes less: Gauss-Newton on the logarithms of their lengths, led by
  /// those that are farthest from 1. No element gets worse that is below the floor.
  bool move_to_relax(VertId v, double floor_q3);
  /// Tries steps along the axes of the metric and takes the one with the best worst element. For where the metric turns
  /// within an element, and the model of move(), whose metric is constant, points elsewhere.
  bool move_along_axes(VertId v);
  /// Moves v so that the sum of inverse_sixth_power() over its elements becomes less, along the axes of the metric and
  /// to the minimum of parabolas through what is found there: the same for where Newton's model does not hold. No
  /// element gets worse that is below the floor.
  bool move_to_reduce_sum(VertId v, double floor_q3);
  /// Makes the balls of all vertices at once, for many moves of a mesh whose topology does not change until drop_index.
  void index_balls();
  void drop_index() noexcept;
  /// With an index: ask for the tetrahedra that move(v) will read, some moves ahead, and, when these are there, for
  /// their vertices.
  void fetch_ball(VertId v) const noexcept;
  void fetch_vertices(VertId v) const noexcept;

 private:
  /// Where v may move: the whole space, a plane or a line.
  struct Freedom {
    int dims = 3;
    Vec3 t0, t1;  ///< orthonormal directions of the plane or line
  };
  bool freedom(VertId v, Freedom& f);
  /// The elements at a vertex.
  struct Ball {
    double sum = 0, low = 1;  ///< of 1/Q^3; the least Q^3
    Freedom free;
  };
  /// Ball and cone of v; false if it may not move.
  bool gather(VertId v, Ball& ball);
  /// Q^3 of the ball with its vertex at x (Cone::judge), carefully if that is wanted. What is below the
  /// bound may be less still.
  double judge(Vec3 x, const VertMetric& m, double bound);
  void place(VertId v, Vec3 x, const VertMetric& m, const SymTensor& log_m);
  /// Lists the neighbours of v in link_; returns how many.
  std::size_t list_link(VertId v);
  [[nodiscard]] Vec3 relaxing_step(VertId v, std::size_t links, const Freedom& free, double& strain) const;
  /// `gain`: the relative decrease of the sum that the step promises.
  [[nodiscard]] Vec3 newton_step(VertId v, const Freedom& f, double& gain);
  /// Towards where springs of metric length 1 along the edges at v are in balance (the chapter's mesh cosmetics).
  [[nodiscard]] Vec3 spring_step(VertId v, const Freedom& f) const;
  /// The log-metric at x(v) + step; false beyond the ball.
  [[nodiscard]] bool interpolate(VertId v, Vec3 step, SymTensor& log_m);
  /// The same from the anchor of v; false also when the anchor cannot see the place from inside the ball.
  [[nodiscard]] bool interpolate_from_anchor(VertId v, Vec3 x, SymTensor& log_m);
  bool attempt(VertId v, Vec3 step, double old_sum, double old_min);
  void mark_changed(VertId v);
  bool find_ball(VertId v);
  [[nodiscard]] std::span<const FaceId> indexed_ball(VertId v) const noexcept;

  Part* part_;
  Cone cone_;
  std::vector<FaceId> ball_;         ///< the faces opposite the vertex at hand
  std::vector<TetId> tets_;          ///< scratch
  std::vector<VertId> link_;         ///< scratch: the neighbours of a vertex
  std::vector<std::int32_t> first_;  ///< of balls_, per vertex and one more; empty without an index
  std::vector<FaceId> balls_;
};

}  // namespace skein
