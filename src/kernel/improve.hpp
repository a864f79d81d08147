// Improvement passes: work on single elements and edges that the main passes have left far from what was wanted.
#pragma once
#include "kernel/operators/collapse.hpp"
#include "kernel/operators/smooth.hpp"
#include "kernel/operators/swap.hpp"
#include "kernel/part.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// Sweeps that try every operator on what is poor, until none helps. What has been tried in vain is tried again only
/// when something has changed round it.
class Improver {
 public:
  Improver(Part& part, Collapser& collapse, Swapper& swap, Smoother& smooth)
      : part_(&part), collapse_(&collapse), swap_(&swap), smooth_(&smooth) {
    make_all_new();
  }

  /// Works on the elements below `target` with the objective RaiseWorst.
  void raise_worst(double target);
  /// Works on the elements below `target` with the objective LowerSum. @pre QualityMeasure::kLeast.
  void lower_sum(double target, double floor);
  /// Works on edges that are too long or too short with the objective LowerStrain, in so many sweeps at most.
  void lower_strain(int turns);
  /// From now on elements are measured like this; all of them count as new.
  void set_measure(QualityMeasure measure);
  /// Clears the passes' bits of Part::dirty, which then tell what changes. Where no element is below `quality`, returns
  /// false; else those that touch one, and all that will be made, have QualityMeasure::kLeast until leave_few().
  bool measure_few(double quality);
  void leave_few();

 private:
  /// Calls work(t) for the elements below target that are new, in sweeps until none returns true.
  template <class Work>
  void sweep(Pass pass, double target, Work&& work);
  /// Nothing has been tried: all that is to be improved is new to both passes.
  void make_all_new();
  /// Makes state_ from what has changed or was there from the start and has not been tried by this pass since.
  void note_changes(Pass pass);
  /// Tells whether t is new: it, or something at a vertex of it, has changed since it was tried. It counts as tried.
  [[nodiscard]] bool take(TetId t, Pass pass) noexcept;
  bool smooth_in(TetId t);
  bool move_along_axes_in(TetId t);
  bool remove_vertex_in(TetId t);
  bool lower_sum_in(TetId t, double floor_q3);
  bool lower_strain_in(TetId t);
  bool lower_strain_of(TetId t, VertId a, VertId b);

  Part* part_;
  Collapser* collapse_;
  Swapper* swap_;
  Smoother* smooth_;
  Shell shell_;
  enum : std::uint8_t { kChanged = 1, kToMove = 2 };
  IdVector<VertId, std::uint8_t> state_;  ///< of the vertices in this sweep
  std::uint8_t all_new_ = 0;              ///< kImprovement for which everything is new, whatever Part::dirty says
  std::vector<TetId> few_, ball_;
};

}  // namespace skein
