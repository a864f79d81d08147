// Every number of a Method with its name, its bounds and what it does: the one list for printing and reading methods.
#pragma once
#include <string_view>
#include <type_traits>

#include "kernel/method.hpp"

namespace skein {

/// Calls visit(name, number, least, most, text) for each number of the method; `name` is "section.key", `number` an int
/// or a double (of a const or mutable method), `text` one line.
// One list, the longer the more numbers there are.
template <class M, class Visit>  // NOLINTNEXTLINE(readability-function-size)
void for_each_number(M&& m, Visit&& visit) {
  visit("lengths.split_above", m.lengths.split_above, 0.5, 10, "edges longer than this get points");
  visit("lengths.collapse_below", m.lengths.collapse_below, 0, 2, "edges shorter than this lose an end");
  visit("lengths.closest_new", m.lengths.closest_new, 0, 2, "no new point closer than this to another");
  visit("lengths.first_step", m.lengths.first_step, 1, 10, "points first on edges this much longer than split_above");
  visit("lengths.runaway", m.lengths.runaway, 1, 1000, "a pass ends at this many times the predicted points");

  visit("facets.max_turn", m.facets.max_turn, 0, 90, "degrees an operation may turn a facet's normal");
  visit("facets.swap_deviation", m.facets.swap_deviation, 0, 1, "how far a swap may leave old facets, of the edge");
  visit("facets.collapse_deviation", m.facets.collapse_deviation, 0, 1, "the same for a collapse");

  visit("patches.max_turn", m.patches.max_turn, 0, 90, "the same where the surface is curved");
  visit("patches.max_angle", m.patches.max_angle, 0, 90, "degrees between a facet's normal and the surface's");

  visit("insert.good_quality", m.insert.good_quality, 0, 1,
        "elements above this are always good enough at a new point");
  visit("insert.seed_share", m.insert.seed_share, 0, 1, "of the worst old Q^3: enough elsewhere");
  visit("insert.strict_floor", m.insert.strict_floor, 0, 1, "quality no point may go below in improvement passes");
  visit("insert.fixed_face_floor", m.insert.fixed_face_floor, 0, 1, "quality no point may go below at faces that stay");
  visit("insert.needle", m.insert.needle, 0, 1, "elements below this are swapped before they get a point");
  visit("insert.largest_cavity", m.insert.largest_cavity, 8, 10000, "tetrahedra from which on a cavity grows no more");
  visit("insert.shrink_turns", m.insert.shrink_turns, 1, 100, "attempts to make a cavity star-shaped");

  visit("collapse.floor", m.collapse.floor, 0, 1, "quality that a collapse of a short edge must leave");
  visit("collapse.share", m.collapse.share, 0, 1, "of the worst old Q^3: enough where that is below the floor");
  visit("collapse.first_below", m.collapse.first_below, 0, 1, "much shorter edges go first: this times collapse_below");
  visit("collapse.longest_of_poor", m.collapse.longest_of_poor, 1, 100, "edge that removing a poor element may leave");

  visit("swap.gain", m.swap.gain, 1, 10, "factor in Q^3 by which the worst element must get better");
  visit("swap.quick_ring", m.swap.quick_ring, 3, 9, "vertices round an edge that is swapped in bulk");
  visit("swap.any_ring_below", m.swap.any_ring_below, 0, 1, "below this quality an edge may have more of them");

  visit("smooth.least_gain", m.smooth.least_gain, 0, 1, "decrease of the sum of 1/Q^3 a step must promise, relative");
  visit("smooth.shortest_step", m.smooth.shortest_step, 0, 1, "metric length; less is not worth a move");
  visit("smooth.longest_step", m.smooth.longest_step, 0, 10, "metric length; longer steps are cut");
  visit("smooth.good_quality", m.smooth.good_quality, 0, 1, "elements may become worse down to this");
  visit("smooth.sum_share", m.smooth.sum_share, 0, 1, "of the old sum of 1/Q^3: the new one must be less");
  visit("smooth.shorter", m.smooth.shorter, 0, 1, "factor of the next try");
  visit("smooth.tries_of_poor", m.smooth.tries_of_poor, 1, 20, "tries at poor elements");

  visit("snap.floor", m.snap.floor, 0, 1, "quality that elements keep when a vertex comes onto the surface");
  visit("snap.share", m.snap.share, 0, 1, "of the worst old Q^3: enough where that is below the floor");
  visit("snap.sweeps", m.snap.sweeps, 1, 20, "sweeps over the vertices that are off the surface");

  visit("strain.floor", m.strain.floor, 0, 1, "no element below this gets worse for the sake of edges");
  visit("strain.longest_new", m.strain.longest_new, 1, 100, "edge that a collapse may leave");
  visit("strain.swap_floor_share", m.strain.swap_floor_share, 0, 1, "of that floor in Q^3, for swaps");
  visit("strain.swap_strain_share", m.strain.swap_strain_share, 0, 1, "of the old edge's strain: new ones have less");
  visit("strain.shape", m.strain.shape, 0, 1, "strain that 1/Q^3 of an element counts as in a move");
  visit("strain.least_decrease", m.strain.least_decrease, 0, 1, "strain that a move must take away");

  visit("sum.collapse_share", m.sum.collapse_share, 0, 1, "of the old sum of Q^-6 after a collapse");
  visit("sum.swap_share", m.sum.swap_share, 0, 1, "after a swap");
  visit("sum.move_share", m.sum.move_share, 0, 1, "after a move");
  visit("sum.swap_floor_share", m.sum.swap_floor_share, 0, 1, "of the floor in Q^3, for swaps");

  visit("main.most_turns", m.main.most_turns, 1, 100, "turns of swap, smooth, collapse, insert");
  visit("main.least_turns", m.main.least_turns, 1, 100, "turns even if little changes any more");
  visit("main.least_turns_after_growth", m.main.least_turns_after_growth, 1, 100, "the same for a mesh that has grown");
  visit("main.settled_in", m.main.settled_in, 1, 1000000, "turns end when not one vertex in so many comes or goes");
  visit("main.swap_below", m.main.swap_below, 0, 1, "quality below which elements are swapped");
  visit("main.swap_below_coarsened", m.main.swap_below_coarsened, 0, 1,
        "the same in a mesh that has lost most vertices");
  visit("main.stretch_coarsened", m.main.stretch_coarsened, 1, 2,
        "there: times split_above, edge a collapse may leave");
  visit("main.smooth_below_first", m.main.smooth_below_first, 0, 1, "quality below which the first turn smooths");
  visit("main.smooth_below", m.main.smooth_below, 0, 1, "the same for later turns");
  visit("main.reorder_growth", m.main.reorder_growth, 2, 1000, "a mesh that has grown so is put in memory order again");
  visit("main.reorder_least", m.main.reorder_least, 1, 1000000000, "... if it has so many tetrahedra");

  const auto bounds = [&](std::string_view longest, std::string_view shortest, std::string_view longest_new,
                          std::string_view closest_new, auto& b) {
    visit(longest, b.longest, 1, 100, "edges longer than this are split");
    visit(shortest, b.shortest, 0, 1, "edges shorter than this are collapsed");
    visit(longest_new, b.longest_new, 1, 100, "edge that a collapse may leave");
    visit(closest_new, b.closest_new, 0, 2, "no new point closer than this to another");
  };
  bounds("improve.far_longest", "improve.far_shortest", "improve.far_longest_new", "improve.far_closest_new",
         m.improve.far);
  bounds("improve.very_far_longest", "improve.very_far_shortest", "improve.very_far_longest_new",
         "improve.very_far_closest_new", m.improve.very_far);
  visit("improve.length_turns", m.improve.length_turns, 0, 100, "sweeps of a pass over lengths");
  visit("improve.smooth_below", m.improve.smooth_below, 0, 1, "quality below which elements are smoothed");
  visit("improve.worst_below", m.improve.worst_below, 0, 1,
        "quality below which elements are poor: improved one by one");
  visit("improve.worst_again_below", m.improve.worst_again_below, 0, 1, "the same in the pairs of passes at the end");
  visit("improve.pairs", m.improve.pairs, 0, 100, "pairs of passes over lengths and worst elements at the end");
  visit("improve.worst_gain", m.improve.worst_gain, 1, 10, "factor in Q^3 that removing a vertex must bring");
  visit("improve.axes_below", m.improve.axes_below, 0, 1,
        "quality below which steps along the metric's axes are tried");
  visit("improve.axes_gain", m.improve.axes_gain, 1, 10, "factor in Q^3 that such a step must bring");
  visit("improve.most_sweeps", m.improve.most_sweeps, 1, 100000, "a guard: sweeps end by themselves long before");
  visit("improve.strain_turns", m.improve.strain_turns, 0, 100, "sweeps over strained edges where lengths differ");
  visit("improve.bad_quality", m.improve.bad_quality, 0, 1, "quality below which elements are bad in any mesh");
  visit("improve.bad_floor", m.improve.bad_floor, 0, 1, "floor when the sum is lowered for these");
  visit("improve.perhaps_bad", m.improve.perhaps_bad, 0, 1, "elements below this are measured over all their metrics");
  visit("improve.bad_pairs", m.improve.bad_pairs, 0, 100, "pairs of passes for bad elements");

  visit("turning.poor_share", m.turning.poor_share, 0, 1, "more poor elements than this: the metric turns in elements");
  visit("turning.bad_share", m.turning.bad_share, 0, 1,
        "or more bad ones: round a surface far coarser than the metric");
  visit("turning.adapted_before", m.turning.adapted_before, 0, 1,
        "fewer strained edges: adapted to this metric before");
  visit("turning.settled_share", m.turning.settled_share, 0, 1, "fewer than this: the main passes are left out");
  visit("turning.settled_bad_share", m.turning.settled_bad_share, 0, 1,
        "... if there are fewer bad elements than this");
  visit("turning.strain_turns", m.turning.strain_turns, 0, 100, "sweeps over strained edges");
  visit("turning.sum_below", m.turning.sum_below, 0, 1, "quality below which the sum of Q^-6 is lowered");
  visit("turning.worst_below", m.turning.worst_below, 0, 1, "quality below which the worst are raised");
  visit("turning.sum_floor", m.turning.sum_floor, 0, 1, "floor of the last passes over the sum");
  visit("turning.pairs", m.turning.pairs, 0, 100, "pairs of passes over the sum and the worst");

  visit("retry.bad_quality", m.retry.bad_quality, 0, 1, "worse elements beside frozen vertices are looked at again");
  visit("retry.bad_long", m.retry.bad_long, 1, 100, "so are longer edges");
  visit("retry.bad_short", m.retry.bad_short, 0, 1, "and shorter ones, once");
  visit("retry.good_quality", m.retry.good_quality, 0, 1, "better elements beside frozen vertices need no more work");

  visit("growth.per_step", m.growth.per_step, 8, 1000, "elements out of one in a step of growth");
  visit("growth.most_steps", m.growth.most_steps, 0, 100, "steps in which a mesh grows that is too small to be cut");
  visit("growth.smallest_part", m.growth.smallest_part, 1, 1e9, "predicted tetrahedra of a part at least");
  visit("growth.smallest_cut", m.growth.smallest_cut, 1, 1e9, "tetrahedra of a part at least when it is cut");
  visit("growth.stretch_above", m.growth.stretch_above, 1, 1e9,
        "elements that the metric stretches more than this against the mesh are reached in steps");
  visit("growth.stretch_left", m.growth.stretch_left, 1, 1e9, "... and what is left by such steps, where they end");
  visit("growth.stretch_step", m.growth.stretch_step, 2, 1000, "edges out of one in such a step");
  visit("growth.stretch_least", m.growth.stretch_least, 0, 1e9, "predicted elements for which such a step pays");
  visit("growth.stretch_progress", m.growth.stretch_progress, 0, 1, "logarithm by which each must lower the stretch");

  visit("rounds.mending", m.rounds.mending, 0, 100, "rounds after the others, for what frozen vertices have left bad");
  visit("rounds.layers", m.rounds.layers, 1, 100, "layers by which interfaces move after the first round");
  visit("rounds.layers_later", m.rounds.layers_later, 1, 100, "... and later, when few move");
  visit("rounds.active_layers", m.rounds.active_layers, 1, 100, "layers round old interfaces that are worked on again");
  visit("rounds.margin", m.rounds.margin, 0, 100, "layers round these that cavities may reach into");
  visit("rounds.directed_above", m.rounds.directed_above, 0, 10, "difference of log M by direction that counts as one");
  visit("rounds.part_imbalance", m.rounds.part_imbalance, 0.001, 1, "of the parts' predicted work");
  visit("rounds.old_interface_weight", m.rounds.old_interface_weight, 1, 100,
        "of faces of old interfaces in a new cut");
  visit("rounds.result_imbalance", m.rounds.result_imbalance, 0.001, 1, "tetrahedra per rank of the result, to this");
  visit("rounds.result_good_enough", m.rounds.result_good_enough, 0.001, 1, "... unless they are this good already");

  visit("threads.smallest_block", m.threads.smallest_block, 1, 1000000000, "tetrahedra for which a thread pays");
  visit("threads.smallest_band", m.threads.smallest_band, 1, 1000000000, "the same in a band, of which few change");
  visit("threads.block_imbalance", m.threads.block_imbalance, 0.001, 1, "of the blocks' predicted work");
  visit("threads.idle_work", m.threads.idle_work, 0, 1, "work in a tetrahedron that is not active");
  visit("threads.frozen_one_in", m.threads.frozen_one_in, 1, 1000, "a part with more frozen vertices is not cut again");
}

}  // namespace skein
