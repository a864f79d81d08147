// Objectives: what an operation must improve, as an argument of the operators. They are known at compile time.
#pragma once
#include <algorithm>

namespace skein {

/// An edge that is too short must go, and elements may become worse: down to a floor, and where they are below it
/// already, by a factor.
struct KeepFloor {
  double floor_q3;  ///< Q^3
  double share;     ///< of the worst old Q^3
  /// Q^3 that every new element must exceed, when the worst old one has `old_min`.
  [[nodiscard]] double bound(double old_min) const noexcept { return std::min(floor_q3, share * old_min); }
};

/// The worst element must get better.
struct RaiseWorst {
  double gain;  ///< factor in Q^3, > 1
  [[nodiscard]] double bound(double old_min) const noexcept { return gain * old_min; }
};

/// The strain (metric/measure.hpp) of the edges at hand must get less, and no element worse that is below the floor.
struct LowerStrain {
  double floor_q3;
  double share = 1;         ///< of that bound
  double strain_share = 1;  ///< of the strain that goes: what comes must have less than this
  [[nodiscard]] double bound(double old_min) const noexcept { return share * std::min(old_min, floor_q3); }
};

/// The sum of Q^-6 over the elements at hand must get less, and no element worse that is below the floor. It goes on
/// where a few elements hold each other and the worst of them cannot get better at once.
struct LowerSum {
  double floor_q3;
  double sum_share;  ///< of the old sum: the new one must be less than this, < 1
  double share = 1;  ///< of the bound
  [[nodiscard]] double bound(double old_min) const noexcept { return share * std::min(old_min, floor_q3); }
};

/// The sum of 1/Q^3 over the ball of a vertex must get less, and the worst element must not get worse, or not fall
/// below a good quality. The sum is led by the worst element and smooth: the objective of smoothing as such.
struct SmoothBall {
  int tries = 1;  ///< the full step, then shorter ones; in a converged mesh these hardly ever help
};

/// The vertex must come onto the geometry, or nearer to it. Elements may become worse for it, down to a floor, and
/// where they are below it already, by a factor.
struct ToSurface {
  double floor_q3;
  double share;  ///< of the worst old Q^3
  [[nodiscard]] double bound(double old_min) const noexcept { return std::min(floor_q3, share * old_min); }
};

}  // namespace skein
