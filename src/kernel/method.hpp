// Method: the recipe by which a part is made to fit its metric, with every number that steers it.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "geometry/facets.hpp"
#include "geometry/patches.hpp"

namespace skein {

/// How points are created: along long edges at metric-unit steps, or at centroids with exclusion zones [35.2.3.2].
enum class PointCreation : std::uint8_t { kEdges, kCentroids };
/// How vertices are moved: to the best quality of their elements, or by springs along their edges [35.3.1].
enum class Smoothing : std::uint8_t { kQuality, kSprings };

/// Lengths are metric (1 is ideal), qualities are Q (not cubed). The order of the passes is in recipe.cpp. What each
/// number does is said once, in method_numbers.hpp, where --dump-config and --config find it, too.
struct Method {
  PointCreation points = PointCreation::kEdges;
  Smoothing smoothing = Smoothing::kQuality;
  FacetLimits facets;
  PatchLimits patches;

  struct Lengths {
    double split_above = 1.4142135623;
    double collapse_below = 0.7071067;
    double closest_new = 0.6;
    double first_step = 2;
    int runaway = 4;
  } lengths;

  struct Insert {
    double good_quality = 0.2;
    double seed_share = 0.125;
    double strict_floor = 0.05;
    double fixed_face_floor = 0.3;
    double needle = 0.1;
    int largest_cavity = 96;
    int shrink_turns = 4;
  } insert;

  struct Collapse {
    double floor = 0.3;
    double share = 0.5;
    double first_below = 0.5;
    double longest_of_poor = 2;
  } collapse;

  struct Swap {
    double gain = 1.05;
    int quick_ring = 4;
    double any_ring_below = 0.45;
  } swap;

  struct Smooth {
    double least_gain = 0.004;
    double shortest_step = 0.01;
    double longest_step = 0.5;
    double good_quality = 0.5;
    double sum_share = 0.995;
    double shorter = 0.4;
    int tries_of_poor = 3;
  } smooth;

  struct Snap {
    double floor = 0.1;
    double share = 0.3;
    int sweeps = 3;
  } snap;

  struct Strain {
    double floor = 0.4;
    double longest_new = 1.8;
    double swap_floor_share = 0.99;
    double swap_strain_share = 0.95;
    double shape = 0.005;
    double least_decrease = 0.01;
  } strain;

  struct Sum {
    double collapse_share = 0.99;
    double swap_share = 0.995;
    double move_share = 0.998;
    double swap_floor_share = 0.999;
  } sum;

  struct MainPasses {
    int most_turns = 5;
    int least_turns = 2;
    int least_turns_after_growth = 4;
    int settled_in = 20;
    double swap_below = 0.7;
    double swap_below_coarsened = 0.8;
    double stretch_coarsened = 1.03;
    double smooth_below_first = 0.9;
    double smooth_below = 0.85;
    int reorder_growth = 3;
    int reorder_least = 50'000;
  } main;

  /// Bounds of a pass over edges that the main passes have left far from unit length.
  struct LengthBounds {
    double longest, shortest;         ///< edges beyond are worked on
    double longest_new, closest_new;  ///< looser than in the main passes: bounds on what is made in their place
  };

  struct Improve {
    LengthBounds far{1.8, 0.55, 1.8, 0.45};
    LengthBounds very_far{2.1, 0.4, 2.2, 0.35};
    int length_turns = 4;
    double smooth_below = 0.75;
    double worst_below = 0.5;
    double worst_again_below = 0.4;
    int pairs = 2;
    double worst_gain = 1.2;
    double axes_below = 0.35;
    double axes_gain = 1.01;
    int most_sweeps = 500;
    int strain_turns = 1;
    double bad_quality = 0.2;
    double bad_floor = 0.15;
    double perhaps_bad = 0.3;
    int bad_pairs = 2;
  } improve;

  struct Turning {
    double poor_share = 0.05;
    double bad_share = 0.01;
    double adapted_before = 0.3;
    double settled_share = 0.04;
    double settled_bad_share = 0.0003;
    int strain_turns = 4;
    double sum_below = 0.4;
    double worst_below = 0.39;
    double sum_floor = 0.36;
    int pairs = 3;
  } turning;

  struct Retry {
    double bad_quality = 0.3;
    double bad_long = 2;
    double bad_short = 0.4;
    double good_quality = 0.75;
  } retry;

  struct Growth {
    double per_step = 12;
    int most_steps = 10;
    double smallest_part = 12000;
    double smallest_cut = 4000;
    double stretch_above = 32;
    double stretch_left = 8;
    double stretch_step = 4;
    double stretch_least = 100;
    double stretch_progress = 0.3;
  } growth;

  struct Rounds {
    int mending = 2;
    int layers = 1;
    int layers_later = 2;
    int active_layers = 1;
    int margin = 0;
    double directed_above = 0.2;
    double part_imbalance = 0.01;
    int old_interface_weight = 4;
    double result_imbalance = 0.03;
    double result_good_enough = 0.04;
  } rounds;

  struct Threads {
    int smallest_block = 2000;
    int smallest_band = 50'000;
    double block_imbalance = 0.005;
    double idle_work = 0.01;
    int frozen_one_in = 10;
  } threads;
};

/// A method by its name.
struct Preset {
  std::string_view name;
  std::string_view what;  ///< in one line
  Method method;
};
/// All there are, the default first.
const std::array<Preset, 3>& presets();

}  // namespace skein
