// The metric to adapt to: complexity met after clamps and gradation, sizes kept, one step for every kind of input.
#include "solution/metric_policy.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "metric/complexity.hpp"
#include "metric/gradation.hpp"
#include "tests/support/dealt_cube.hpp"

namespace skein {
namespace {

using test::DealtCube;
using test::sample;
using test::world;

constexpr double kInf = std::numeric_limits<double>::infinity();

/// Small at two spots, one of them on the line where four ranks meet.
double spots(Vec3 x) {
  const double a = norm(x - Vec3{0.5, 0.5, 0.2}), b = norm(x - Vec3{0, 1, 1});
  return a < 0.1 ? 0.02 : b < 0.1 ? 0.01 : 0.5;
}
/// Flat in a direction that turns with z, within a layer.
SymTensor layer(Vec3 x) {
  const double c = std::cos(x.z), s = std::sin(x.z), d = std::abs(c * (x.x - 0.5) + s * (x.y - 0.5));
  return compose({{1, 4, d < 0.15 ? 1e4 : 9}, {Vec3{-s, c, 0}, Vec3{0, 0, 1}, Vec3{c, s, 0}}});
}
double front(Vec3 x) { return std::tanh(10 * (x.x + 0.3 * x.y - 0.6)); }

struct Case {
  DistMesh dist;
  std::vector<SymTensor> log_metric;
};
Case sizes(const Comm& comm, const DealtCube& cube) {
  Case c{cube.part(comm), {}};
  for (const double h : sample(c.dist, spots)) c.log_metric.push_back(isotropic(-2 * std::log(h)));
  return c;
}
Case tensors(const Comm& comm, const DealtCube& cube) {
  Case c{cube.part(comm), {}};
  for (const Vec3 x : c.dist.mesh.coords) c.log_metric.push_back(log(layer(x)));
  return c;
}
/// One of both, as the policy says.
Case given(const Comm& comm, const MetricPolicy& policy, const DealtCube& cube = {8, 0.2}) {
  return policy.source == MetricSource::kSizes ? sizes(comm, cube) : tensors(comm, cube);
}

double smallest_size(const SymTensor& l) { return std::exp(-0.5 * eigen(l).value[2]); }
double largest_size(const SymTensor& l) { return std::exp(-0.5 * eigen(l).value[0]); }

/// The largest factor by which sizes grow over an edge, above what the gradation allows.
double excess_growth(const Case& c, double growth) {
  double worst = 0;
  for (const auto& t : c.dist.mesh.tet2vert) {
    for (const VertId v : t) {
      for (const VertId w : t) {
        if (v == w) continue;
        const Vec3 e = c.dist.mesh.coords[w] - c.dist.mesh.coords[v];
        const SymTensor from = exp(c.log_metric[idx(v)]), to = exp(c.log_metric[idx(w)]);
        const double allowed = 1 + std::log(growth) * std::sqrt(quad(from, e));
        for (const Vec3 d : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, -1, 1}})
          worst = std::max(worst, std::sqrt(quad(from, d) / quad(to, d)) / allowed - 1);
      }
    }
  }
  return worst;
}

TEST(ComplexityFromLog, OfAUniformMetricIsVolumeOverCubeOfSize) {
  const DistMesh dist = DealtCube{5, 0.2}.part(world());
  const std::vector<SymTensor> metric(dist.mesh.vert_slots(), isotropic(-2 * std::log(0.1)));
  EXPECT_NEAR(complexity_from_log(world(), dist, metric), 1000, 1e-8);
}

TEST(ScaleComplexity, ScalesItAndKeepsTheShape) {
  Case c = tensors(world(), {6, 0.2});
  const auto before = c.log_metric;
  const double now = complexity_from_log(world(), c.dist, c.log_metric);
  scale_complexity(7, c.log_metric);
  EXPECT_NEAR(complexity_from_log(world(), c.dist, c.log_metric), 7 * now, 1e-11 * now);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(c.log_metric[i].xy, before[i].xy);
    EXPECT_NEAR(c.log_metric[i].xx - before[i].xx, 2.0 / 3 * std::log(7), 1e-12);
  }
}

TEST(ClampSizes, KeepsSizesInBoundsAndTheRestAsItWas) {
  Case c = tensors(world(), {6, 0.2});
  const auto before = c.log_metric;
  clamp_sizes({}, c.log_metric);
  EXPECT_EQ(c.log_metric, before);
  clamp_sizes({.h_min = 0.1, .h_max = 0.6}, c.log_metric);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double low = smallest_size(before[i]), high = largest_size(before[i]);
    EXPECT_NEAR(smallest_size(c.log_metric[i]), std::clamp(low, 0.1, 0.6), 1e-12);
    EXPECT_NEAR(largest_size(c.log_metric[i]), std::clamp(high, 0.1, 0.6), 1e-12);
  }
}

TEST(Grade, BoundsTheGrowthOfSizesAndTensors) {
  for (const MetricSource source : {MetricSource::kSizes, MetricSource::kTensors}) {
    const MetricPolicy policy{.source = source, .gradation = 1.4};
    Case c = given(world(), policy);
    const auto before = c.log_metric;
    EXPECT_EQ(grade(world(), c.dist, {.source = source}, c.log_metric).lowered, 0);
    EXPECT_EQ(c.log_metric, before);
    const GradationReport report = grade(world(), c.dist, policy, c.log_metric);
    EXPECT_GT(report.lowered, 0);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(excess_growth(c, policy.gradation), 2 * kGradationTolerance);
    for (std::size_t i = 0; i < before.size(); ++i)
      EXPECT_LE(largest_size(c.log_metric[i]) / largest_size(before[i]), 1 + 1e-9);
  }
}

TEST(ScaleToComplexity, IsMetAfterTheGradation) {
  for (const MetricSource source : {MetricSource::kSizes, MetricSource::kTensors}) {
    for (const double gradation : {0.0, 1.5}) {
      const MetricPolicy policy{.source = source, .complexity = 3000, .gradation = gradation};
      Case c = given(world(), policy);
      static_cast<void>(scale_to_complexity(world(), c.dist, policy, c.log_metric));
      const double tolerance = gradation == 0 ? 1e-9 : 1e-3;
      EXPECT_NEAR(std::log(complexity_from_log(world(), c.dist, c.log_metric)), std::log(3000), tolerance);
      if (gradation > 0) {
        EXPECT_LT(excess_growth(c, gradation), 2 * kGradationTolerance);
      }
    }
  }
}

TEST(ScaleToComplexity, ClampsComeBeforeTheGradationAndHoldAfterIt) {
  for (const MetricSource source : {MetricSource::kSizes, MetricSource::kTensors}) {
    const MetricPolicy policy{.source = source, .complexity = 3000, .h_min = 0.02, .h_max = 0.15, .gradation = 1.3};
    Case c = given(world(), policy);
    static_cast<void>(scale_to_complexity(world(), c.dist, policy, c.log_metric));
    for (const SymTensor& l : c.log_metric) {
      EXPECT_LE(largest_size(l), 0.15 * (1 + 1e-9));
      // Intersections of tensors that are turned against each other have smaller sizes than both.
      if (source == MetricSource::kSizes) {
        EXPECT_GE(smallest_size(l), 0.02 * (1 - 1e-9));
      }
    }
    EXPECT_LT(excess_growth(c, policy.gradation), 2 * kGradationTolerance);
  }
}

TEST(ScaleToComplexity, WhatHasNoneIsRefusedWithItsName) {
  Case c = sizes(world(), {3, 0});
  for (SymTensor& l : c.log_metric) l = isotropic(-2000);
  const MetricPolicy policy{.complexity = 100, .name = "wing.solb"};
  try {
    static_cast<void>(scale_to_complexity(world(), c.dist, policy, c.log_metric));
    FAIL() << "not refused";
  } catch (const AgreedError& e) {
    EXPECT_NE(std::string(e.what()).find("wing.solb: its complexity is 0"), std::string::npos) << e.what();
  }
}

TEST(MetricFromField, MeetsTheComplexityWithClampsAndGradation) {
  for (const double gradation : {0.0, 1.5}) {
    const MetricPolicy policy{.source = MetricSource::kField,
                              .complexity = 2000,
                              .h_min = 0.005,
                              .h_max = 0.4,
                              .norm = 2,
                              .gradation = gradation};
    Case c{DealtCube{8, 0.1}.part(world()), {}};
    c.log_metric.resize(c.dist.mesh.vert_slots());
    static_cast<void>(metric_from_field(world(), c.dist, policy, sample(c.dist, front), c.log_metric));
    EXPECT_NEAR(std::log(complexity_from_log(world(), c.dist, c.log_metric)), std::log(2000), 1e-3);
    for (const SymTensor& l : c.log_metric) {
      EXPECT_GE(smallest_size(l), 0.005 * (1 - 1e-3));
      EXPECT_LE(largest_size(l), 0.4 * (1 + 1e-6));
    }
  }
}

TEST(MakeMetric, IsTheStepOfItsSourceAndTheRanksDoNotMatter) {
  const auto run = [](const Comm& comm, const MetricPolicy& policy) {
    Case c = policy.source == MetricSource::kField ? Case{DealtCube{8, 0.2}.part(comm), {}} : given(comm, policy);
    if (policy.source == MetricSource::kField) {
      c.dist.mesh.fields = {1, sample(c.dist, front)};
    } else {
      c.dist.mesh.log_metric = IdVector<VertId, SymTensor>(c.log_metric);
    }
    static_cast<void>(make_metric(comm, c.dist, policy));
    c.log_metric = c.dist.mesh.log_metric.raw();
    return c;
  };
  for (const MetricSource source : {MetricSource::kSizes, MetricSource::kTensors, MetricSource::kField}) {
    for (const double complexity : {0.0, 2000.0}) {
      if (complexity == 0 && source == MetricSource::kField) continue;
      const MetricPolicy policy{.source = source, .complexity = complexity, .h_min = 0.01, .gradation = 1.5};
      const Case alone = run(Comm::self(), policy), mine = run(world(), policy);
      for (const VertId v : IdRange<VertId>(mine.log_metric.size())) {
        const SymTensor d = mine.log_metric[idx(v)] + -1.0 * alone.log_metric[idx(mine.dist.vert2gid[v])];
        EXPECT_LT(quad(d, {1, 1, 1}) + quad(d, {1, 0, 0}) + quad(d, {0, 1, -1}), 1e-5);
      }
    }
  }
}

FieldSlice slice_of(FieldKind kind, std::vector<double> values) {
  FieldSlice f;
  f.path = "given.sol", f.first = 10, f.total = 100;
  f.kinds = {kind}, f.width = components(kind), f.values = std::move(values);
  return f;
}
std::string refusal(const FieldSlice& f, MetricSource source) {
  try {
    static_cast<void>(metric_values(f, source));
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInput);
    return e.what();
  }
  return {};
}

TEST(MetricValues, BecomeTheLogarithm) {
  const FieldSlice of_sizes = metric_values(slice_of(FieldKind::kScalar, {0.5, 2}), MetricSource::kSizes);
  EXPECT_EQ(of_sizes.width, 6);
  EXPECT_EQ(of_sizes.first, 10);
  EXPECT_NEAR(of_sizes.values.at(0), std::log(4.0), 1e-15);
  EXPECT_EQ(of_sizes.values.at(1), 0);
  EXPECT_NEAR(of_sizes.values.at(11), -std::log(4.0), 1e-15);
  const FieldSlice of_tensors =
      metric_values(slice_of(FieldKind::kTensor, {4, 0, 9, 0, 0, 16}), MetricSource::kTensors);
  EXPECT_NEAR(of_tensors.values.at(2), std::log(9.0), 1e-14);
  const auto field = slice_of(FieldKind::kScalar, {1, -3});
  EXPECT_EQ(metric_values(field, MetricSource::kField).values, field.values);
}

TEST(MetricValues, AreRefusedWithPathAndVertexNumber) {
  const auto expect = [](const FieldSlice& f, MetricSource source, const char* line) {
    EXPECT_EQ(refusal(f, source).rfind(line, 0), 0U) << refusal(f, source);
  };
  expect(slice_of(FieldKind::kScalar, {1, 0}), MetricSource::kSizes, "given.sol: the size at vertex 12 is 0;");
  expect(slice_of(FieldKind::kScalar, {kInf}), MetricSource::kSizes, "given.sol: the size at vertex 11 is inf;");
  expect(slice_of(FieldKind::kScalar, {1, 2, kInf}), MetricSource::kField,
         "given.sol: the value at vertex 13 is not finite");
  expect(slice_of(FieldKind::kTensor, {1, 0, 1, 0, 0, 1, 1, 0, -2, 0, 0, 1}), MetricSource::kTensors,
         "given.sol: the metric at vertex 12 is not positive: eigenvalues -2, 1, 1");
  expect(slice_of(FieldKind::kTensor, {kInf, 0, 1, 0, 0, 1}), MetricSource::kTensors,
         "given.sol: the metric at vertex 11 is not finite");
}

}  // namespace
}  // namespace skein
