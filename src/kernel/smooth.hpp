// Moving a vertex so that its elements get better.
#pragma once
#include <vector>

#include "kernel/part.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Moves vertices to the minimum of the sum of 1/Q^3 over their ball by damped Newton steps (the sum is led by the
/// worst element and smooth); a step counts only if that sum, with the metric interpolated at the new place, gets
/// smaller and the worst element does not fall below what it was, or below a good quality. Vertices of flat patches
/// move in their plane, those of straight ridges along them, corners and frozen vertices stay.
class Smoother {
 public:
  explicit Smoother(Part& part) : part_(&part) {}
  bool move(VertId v);

 private:
  /// Where v may move: the whole space, a plane or a line.
  struct Freedom {
    int dims = 3;
    Vec3 t0, t1;  ///< orthonormal directions of the plane or line
  };
  struct Face {
    Vec3 a, b, c;  ///< the face opposite v; (v, a, b, c) is positive
    VertMetric m;  ///< the metric of largest determinant among its vertices
    double s0;
  };
  bool freedom(VertId v, Freedom& f);
  [[nodiscard]] Vec3 newton_step(VertId v, const Freedom& f) const noexcept;
  [[nodiscard]] bool interpolate(VertId v, Vec3 x, SymTensor& log_m) const noexcept;
  bool attempt(VertId v, Vec3 x, double old_sum, double old_min);

  Part* part_;
  std::vector<TetId> ball_;
  std::vector<double> fresh_;
};

}  // namespace skein
