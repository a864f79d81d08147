// The order of the passes. Every number is in Method (method.hpp).
#include "kernel/recipe.hpp"

#include <utility>

#include "kernel/passes.hpp"

namespace skein {
namespace {

/// How much work a mesh is worth. Removing vertices leaves worse elements than creating them, and far fewer; so a mesh
/// that has lost more vertices than it keeps gets more: unit edges 96.1 -> 97.6 %, mean quality 0.874 -> 0.882.
struct Care {
  double swap_below;
  double stretch;  ///< times split_above: the longest edge that removing a vertex may leave to be split again
};
Care care_of_refined(const Method& o) noexcept { return {o.main.swap_below, 1}; }
Care care_of_coarsened(const Method& o) noexcept { return {o.main.swap_below_coarsened, o.main.stretch_coarsened}; }

/// So little has changed that the main passes may end.
bool is_settled(const Part& part, std::int64_t changed) noexcept {
  return part.options.method.main.settled_in * changed <= part.live_verts();
}

/// The first step of two; good places for the next one need good elements.
void first_points(Passes& pass, const Part& part, const Care& care) {
  if (is_settled(part, pass.create_coarse_points())) return;
  pass.swap_below(care.swap_below);
  pass.smooth_below(part.options.method.main.smooth_below_first);
}

/// Makes the part fit, but for single edges and elements.
Care main_passes(Passes& pass, Part& part) {
  const Method& o = part.options.method;
  const double below = o.lengths.collapse_below, above = o.lengths.split_above;
  const bool all = !part.options.only_retry();
  // Much shorter ones first, where there may be many.
  if (all) pass.collapse_short(o.collapse.first_below * below, above);
  pass.collapse_short(below, above);
  const Care care = part.counts.collapse > part.live_verts() ? care_of_coarsened(o) : care_of_refined(o);
  if (all) first_points(pass, part, care);
  pass.create_points();
  pass.order_if_grown();
  const int least = part.options.least_turns > 0 ? part.options.least_turns : o.main.least_turns;
  for (int i = 0; i < o.main.most_turns; ++i) {
    pass.swap_below(care.swap_below);
    pass.smooth_below(i == 0 && all ? o.main.smooth_below_first : o.main.smooth_below);
    pass.snap_to_surface();
    std::int64_t changed = pass.collapse_short(below, care.stretch * above);
    changed += pass.create_points();
    if (i + 1 >= least && is_settled(part, changed)) break;
  }
  return care;
}

/// Single edges and elements.
void improve(Passes& pass, const Part& part, const Care& care) {
  const Method::Improve& o = part.options.method.improve;
  pass.improve_lengths(o.far);
  if (part.options.lower_strain) pass.improve().lower_strain(o.strain_turns);
  pass.swap_below(care.swap_below);
  pass.smooth_below(o.smooth_below);
  pass.improve_lengths(o.far);
  pass.improve().raise_worst(o.worst_below);
  // Either may leave something for the other one; what has not changed is not looked at again.
  for (int i = 0; i < o.pairs; ++i) {
    pass.improve_lengths(o.very_far);
    pass.improve().raise_worst(o.worst_again_below);
  }
}

/// The same where the metric turns within the elements of the mesh.
void improve_turning(Passes& pass, const Part& part, const Care& care, bool settled) {
  const Method& m = part.options.method;
  const Method::Turning& o = m.turning;
  Improver& improver = pass.improve();
  improver.set_measure(QualityMeasure::kLeast);
  pass.improve_lengths(m.improve.very_far);
  improver.lower_strain(o.strain_turns);
  if (!settled) {
    pass.swap_below(care.swap_below);
    pass.smooth_below(m.improve.smooth_below);
  }
  improver.lower_sum(settled ? o.sum_below : m.improve.worst_below, 0);
  improver.lower_strain(o.strain_turns);
  improver.lower_sum(o.sum_below, 0);
  improver.raise_worst(o.worst_below);
  // In turns, since each of them leaves the other new places to go on from.
  for (int i = 0; i < o.pairs; ++i) {
    improver.lower_sum(o.worst_below, o.sum_floor);
    improver.raise_worst(o.worst_below);
  }
  improver.set_measure(QualityMeasure::kLargestMetric);
}

/// What is left between vertices that must stay.
void improve_bad(Passes& pass, const Part& part) {
  const Method::Improve& o = part.options.method.improve;
  Improver& improver = pass.improve();
  if (!improver.measure_few(o.perhaps_bad)) return;
  improver.lower_sum(o.bad_quality, o.bad_floor);
  improver.raise_worst(o.bad_quality);
  for (int i = 0; i < o.bad_pairs; ++i) {
    pass.improve_lengths(o.very_far, Passes::Where::kDirty);
    improver.raise_worst(o.bad_quality);
  }
  improver.leave_few();
}

}  // namespace

IdVector<VertId, VertId> adapt_part(Part& part) {
  const Method& m = part.options.method;
  const Method::Turning& o = m.turning;
  Passes pass(part);
  const auto is_turning = [&] {
    return part.options.turning.value_or(pass.share_below(m.improve.worst_below) > o.poor_share);
  };
  const double strained = is_turning() ? pass.strained_share() : 1;
  if (strained < o.adapted_before) pass.anchor();
  const bool settled = strained < o.settled_share && pass.share_below(m.retry.bad_quality) < o.settled_bad_share;
  const Care care = settled ? care_of_refined(m) : main_passes(pass, part);
  pass.snap_to_surface();
  const auto is_bad = [&] { return !part.options.turning && pass.share_below(m.improve.bad_quality) > o.bad_share; };
  part.turning = settled || is_turning() || is_bad();
  if (part.turning) {
    improve_turning(pass, part, care, settled);
  } else {
    improve(pass, part, care);
    improve_bad(pass, part);
  }
  // What had no room before may have it between better elements; those that it makes worse get another turn.
  if (pass.snap_to_surface() > 0) {
    improve_bad(pass, part);
    pass.snap_to_surface();
  }
  part.mesh.anchor = {};
  pass.count_poor(m.improve.worst_below);
  pass.mark_retry();
  return std::move(pass.old2new());
}

IdVector<VertId, VertId> create_coarse_points(Part& part) {
  Passes pass(part);
  first_points(pass, part, care_of_refined(part.options.method));
  return std::move(pass.old2new());
}

}  // namespace skein
