// The passes of the kernel over one part, of which recipe.cpp makes a method.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "kernel/cavity.hpp"
#include "kernel/improve.hpp"
#include "kernel/operators/collapse.hpp"
#include "kernel/operators/insert.hpp"
#include "kernel/operators/smooth.hpp"
#include "kernel/operators/swap.hpp"

namespace skein {

/// One worker's operators and its sweeps over what is dirty.
class Passes {
 public:
  explicit Passes(Part& part);

  /// Removes an end of edges shorter than `below`; no new edge gets longer than max_length.
  std::int64_t collapse_short(double below, double max_length);
  /// Along edges longer than `times` split_above.
  std::int64_t create_points(double times = 1);
  /// Along edges longer than Lengths::first_step split_above: what is shorter is left to the next step.
  std::int64_t create_coarse_points();
  std::int64_t swap_below(double quality);
  std::int64_t smooth_below(double quality);
  /// Moves the vertices of the boundary that are off the surface onto it, or as near as the elements allow; returns how
  /// many are left.
  std::int64_t snap_to_surface();
  /// Where improve_lengths begins.
  enum class Where {
    kChangedOrNew,  ///< what was there from the start or has changed
    kDirty          ///< what has changed since the last such pass
  };
  /// Splits and collapses the edges beyond the bounds, with more places for a point than create_points() tries.
  void improve_lengths(const Method::LengthBounds& bounds, Where where = Where::kChangedOrNew);
  /// Share of the elements that are below this quality.
  [[nodiscard]] double share_below(double quality) const;
  /// Share of the edges, as the tetrahedra meet them, that are too long or too short.
  [[nodiscard]] double strained_share() const;
  /// From now on metrics at vertices that move are interpolated from where they are now (Part::anchors).
  void anchor();
  /// Counts what is still below `target`, by what holds it (OperationCounts).
  void count_poor(double target);
  /// kRetry on the vertices of what is far from what was wanted and is confined, as another round might do better
  /// there; kBesideFrozen on those of what is not good and has a bound vertex; and on no others.
  void mark_retry();
  /// Puts what is near in space near in memory, if much is new.
  void order_if_grown();
  [[nodiscard]] Improver& improve() noexcept { return improve_; }
  /// Vertices before the first pass -> vertices now.
  [[nodiscard]] IdVector<VertId, VertId>& old2new() noexcept { return old2new_; }

 private:
  /// A new sweep asks everywhere again.
  void forget_refused() { part_.refused.assign(part_.mesh.tet_slots(), 0); }
  /// Calls visit(t) for every live, active tetrahedron that is dirty for this pass and wanted(t), after taking the bit
  /// away, in up to `sweeps` sweeps, as long as there are any. `wanted` is asked first, so it should be cheap.
  template <class Wanted, class Visit>
  void sweep(Pass pass, int sweeps, Wanted&& wanted, Visit&& visit);
  void order();
  /// Tetrahedra from which on a sweep puts the mesh in order again, as it no longer fits the caches as it lies.
  [[nodiscard]] std::size_t reorder_above() const noexcept;
  /// Asks for the tetrahedra round t, which a look at its rings will read.
  void fetch_neighbours(TetId t) const noexcept;
  enum class Outcome { kNothingToDo, kInVain, kDone };
  Outcome collapse_in(TetId t, double below, double max_length);
  /// Places for a point on a long edge.
  enum class Places { kUnitSteps, kMany };
  /// An edge that is too long.
  struct LongEdge {
    double length, ratio;  ///< ratio of the lengths in the metrics of b and a
    VertId a, b;
  };
  /// Lists the edges of t in the mask that are longer than `above`, the longest first; returns how many.
  std::size_t list_long(TetId t, unsigned mask, double above, std::array<LongEdge, 6>& out) const;
  InsertResult split_edge(TetId t, const LongEdge& edge, Places places);
  /// Splits the longest of the edges above this length that can be.
  Outcome split_in(TetId t, double above, Places places);
  void create_point_in(TetId t, double above);
  /// A vertex of the boundary that may move and is not on the surface.
  [[nodiscard]] bool is_off_surface(VertId v) const;
  /// True if something was split or collapsed.
  bool improve_lengths_in(TetId t, const Method::LengthBounds& bounds);
  void centroid_in(TetId t, double above);
  /// Takes all marks of mark_retry away; tells whether a vertex is bound.
  bool unmark_retry();
  /// kBesideFrozen where it belongs, and the returned stamp on all vertices beside a bound one.
  std::uint32_t mark_beside_bound();
  [[nodiscard]] bool is_bad(TetId t) const noexcept;
  /// Cannot be worked with. Where only retry vertices are worked on, idle vertices do not count: they have had a round
  /// with nothing in their way, and would hand each other on for ever.
  [[nodiscard]] bool is_bound(VertId v) const noexcept {
    const VertState f = part_.mesh.vert_state[v] & (kFrozen | kActive);
    return part_.options.only_retry() ? f == (kFrozen | kActive) : f != kActive;
  }

  Part& part_;
  Cavity cavity_;
  Inserter insert_;
  Collapser collapse_;
  Swapper swap_;
  Smoother smooth_;
  Improver improve_;
  Shell shell_;
  std::vector<VertId> to_move_;
  IdVector<VertId, VertId> old2new_;
  std::size_t ordered_;  ///< tetrahedra when they were put in order
  double collapsed_below_ = 0;
  /// Bounds of the last pass over lengths. What has changed since or was tried in vain has the bit kInsertPass.
  double improved_above_ = 0, improved_below_ = 0;
  std::int64_t expected_ = -1;  ///< expected_points() before the first points
};

}  // namespace skein
