// The methods that have a name.
#include "kernel/method.hpp"

namespace skein {
namespace {

/// As the chapter has it: points at centroids, vertices moved by springs.
Method as_in_the_chapter() {
  Method m;
  m.points = PointCreation::kCentroids;
  m.smoothing = Smoothing::kSprings;
  return m;
}

/// Less work on single elements.
Method quick() {
  Method m;
  m.main.least_turns = 1;
  m.main.swap_below = 0.6;
  m.main.smooth_below = 0.75;
  m.improve.pairs = 1;
  m.turning.pairs = 1;
  return m;
}

}  // namespace

const std::array<Preset, 3>& presets() {
  static const std::array<Preset, 3> all{
      Preset{"default", "points along edges, vertices moved to the best quality", Method{}},
      Preset{"chapter", "points at centroids [35.2.3.2], vertices moved by springs [35.3.1]", as_in_the_chapter()},
      Preset{"quick", "fewer passes over single elements: faster, somewhat poorer", quick()}};
  return all;
}

}  // namespace skein
