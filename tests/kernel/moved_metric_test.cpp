// Vertices that move take their metrics with them, interpolated at the new place.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "kernel/operators/smooth.hpp"
#include "tests/kernel/judge.hpp"
#include "tests/kernel/metrics.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::test {
namespace {

double size_of(const SymTensor& t) {
  return std::sqrt(t.xx * t.xx + t.yy * t.yy + t.zz * t.zz + 2 * (t.xy * t.xy + t.xz * t.xz + t.yz * t.yz));
}
/// The largest difference between the metric at a vertex and the field it comes from, after moves of all vertices.
double error_after_moves(Part& part, const SmoothMetric& field, bool anchored) {
  if (anchored) {
    for (const VertId v : IdRange<VertId>(part.mesh.vert_slots())) {
      part.mesh.anchor.push_back({part.x(v), part.mesh.log_metric[v]});
    }
  }
  Smoother smooth(part);
  for (int turn = 0; turn < 10; ++turn) {
    for (const VertId v : IdRange<VertId>(part.mesh.vert_slots())) {
      smooth.move(v, SmoothBall{});
      smooth.move(v, LowerStrain{0});
      smooth.move(v, LowerSum{0, 0.998});
    }
  }
  double worst = 0;
  for (const VertId v : IdRange<VertId>(part.mesh.vert_slots())) {
    worst = std::max(worst, size_of(part.mesh.log_metric[v] + -1.0 * field.log_at(part.x(v))));
  }
  return worst;
}

RC_GTEST_PROP(MovedMetric, FollowsTheField, ()) {
  MeshSpec spec;
  spec.n = *rc::gen::inRange(2, 5);
  spec.perturb = 0.2;
  spec.seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  SmoothMetric field = random_smooth_metric(random, 0.1, 1.0, 1.5);
  field.turn = {};  // its logarithm is linear then, and so is interpolation
  for (const bool anchored : {false, true}) {
    Part part;
    part.mesh = make_mesh(spec);
    set_metric(part.mesh, field);
    prepare(part);
    RC_ASSERT(error_after_moves(part, field, anchored) < 1e-9);
    RC_ASSERT(part.counts.smooth > 0);
  }
}

TEST(MovedMetric, AnchorsKeepErrorsFromAddingUp) {
  double with = 0, without = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    SmoothMetric field = random_smooth_metric(random, 0.1, 1.0, 1.5);
    field.turn = {2, 1, 0};
    for (const bool anchored : {false, true}) {
      Part part;
      part.mesh = make_mesh({.n = 5, .perturb = 0.2, .seed = seed});
      set_metric(part.mesh, field);
      prepare(part);
      (anchored ? with : without) += error_after_moves(part, field, anchored);
    }
  }
  RecordProperty("with", std::to_string(with));
  EXPECT_LT(with, 0.9 * without);
}

}  // namespace
}  // namespace skein::test
