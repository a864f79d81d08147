// Work on single elements and edges that the passes have left far from what was wanted.
#pragma once
#include "kernel/collapse.hpp"
#include "kernel/part.hpp"
#include "kernel/shell.hpp"
#include "kernel/smooth.hpp"
#include "kernel/swap.hpp"

namespace skein {

/// Sweeps that try every operator on what is poor, until none helps. What has been tried in vain is tried again only
/// when something has changed round it.
class Improver {
 public:
  Improver(Part& part, Collapser& collapse, Swapper& swap, Smoother& smooth)
      : part_(&part), collapse_(&collapse), swap_(&swap), smooth_(&smooth) {
    make_all_new();
  }

  /// Works on the elements below `target`, accepting only what makes the worst element better.
  void worst(double target);
  /// Works on the elements below `target`, accepting what makes the sum of inverse_sixth_power() less, and no element
  /// worse that is below `floor`. It goes on where the worst element of a few that hold each other cannot get better at
  /// once.
  /// @pre judge_carefully(true).
  void reduce_sum(double target, double floor);
  /// Makes edges that are too long or too short fewer by every operator that lessens the strain round them, in so many
  /// sweeps at most.
  void relax(int turns);
  /// From now on elements are judged carefully, or no longer.
  void judge_carefully(bool careful);
  /// Clears the passes' bits of Part::dirty, which then tell what changes. Where no element is below `quality`, returns
  /// false; else those that touch one, and all that will be made, are judged carefully until leave_few().
  bool judge_few_carefully(double quality);
  void leave_few();

 private:
  /// Calls work(t) for the elements below target that are new, in sweeps until none returns true.
  template <class Work>
  void sweep(Pass hunt, double target, Work&& work);
  /// Nothing has been tried: all that is to be hunted is new to both hunts.
  void make_all_new();
  /// Makes state_ from what has changed or was there from the start and has not been tried by this hunt since.
  void note_changes(Pass hunt);
  /// Tells whether t is new: it, or something at a vertex of it, has changed since it was tried. It counts as tried.
  [[nodiscard]] bool take(TetId t, Pass hunt) noexcept;
  bool smooth_in(TetId t);
  bool move_along_axes_in(TetId t);
  bool remove_vertex_in(TetId t);
  bool reduce_sum_in(TetId t, double floor_q3);
  bool relax_edge(TetId t, VertId a, VertId b);

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
