// The metric of a Hessian: complexity met, sizes and aspect ratio kept, scaling laws of the L^p norm.
#include "solution/hessian_metric.hpp"

#include <gtest/gtest.h>

#include "metric/complexity.hpp"
#include "solution/hessian.hpp"
#include "tests/support/dealt_cube.hpp"

namespace skein {
namespace {

using test::DealtCube;
using test::sample;
using test::world;

constexpr double kInf = std::numeric_limits<double>::infinity();

/// A smooth Hessian that varies over orders of magnitude, has negative and zero eigenvalues.
SymTensor wild_hessian(Vec3 x) {
  Eigen e{{1e4 * std::exp(-20 * x.x * x.x), -3 * x.y, 0}, {}};
  const double c = std::cos(x.z), s = std::sin(x.z);
  e.vector = {Vec3{c, s, 0}, Vec3{-s, c, 0}, Vec3{0, 0, 1}};
  return compose(e);
}

struct Fixture {
  DistMesh dist = DealtCube{8, 0.1}.part(world());
  std::vector<SymTensor> hessian, metric;
  Fixture() : metric(dist.mesh.vert_slots()) {
    for (const Vec3 x : dist.mesh.coords) hessian.push_back(wild_hessian(x));
  }
};

double complexity(const DistMesh& dist, const std::vector<SymTensor>& metric) {
  return world().sum(complexity_of(dist.mesh, [&](VertId v) { return vert_metric(metric[idx(v)]).sqrt_det; }));
}

TEST(HessianMetric, meets_the_complexity_with_and_without_clamps) {
  for (const double p : {1.0, 2.0, 4.0, kInf}) {
    for (const auto& [h_min, h_max] : {std::pair{0.0, kInf}, std::pair{0.02, 0.3}, std::pair{0.0, 0.15}}) {
      Fixture f;
      const double reached = hessian_metric(world(), f.dist, 2000, p, h_min, h_max, f.hessian, f.metric);
      EXPECT_NEAR(reached, 2000, 2e-6);
      EXPECT_NEAR(complexity(f.dist, f.metric), 2000, 1e-3);
      for (const auto& m : f.metric) {
        const auto e = eigen(m).value;
        EXPECT_GE(e[0], (1 - 1e-6) / (h_max * h_max));
        EXPECT_LE(e[2] * h_min * h_min, 1 + 1e-6);
        EXPECT_GT(e[0], 0);
        EXPECT_LE(e[2] / e[0], 1.0001e8);
      }
    }
  }
}

TEST(HessianMetric, complexity_out_of_reach_gives_the_nearest) {
  Fixture f;
  EXPECT_NEAR(hessian_metric(world(), f.dist, 1e9, 2, 0.1, 0.2, f.hessian, f.metric), 1000, 1e-6);
  EXPECT_NEAR(hessian_metric(world(), f.dist, 1, 2, 0.1, 0.2, f.hessian, f.metric), 125, 1e-6);
}

TEST(HessianMetric, aspect_ratio_is_limited) {
  Fixture f;
  static_cast<void>(hessian_metric(world(), f.dist, 1000, 2, 0, kInf, f.hessian, f.metric, 5));
  for (const auto& m : f.metric) {
    const auto e = eigen(m).value;
    EXPECT_LE(std::sqrt(e[2] / e[0]), 5 * (1 + 1e-9));
  }
}

TEST(HessianMetric, follows_the_power_law_of_the_norm) {
  // Hessian = diag(8, 2, 1) * k: the metric's determinant must go with k to the power 3 * 2p/(2p+3), its shape stays.
  Fixture f;
  const auto k = [](Vec3 x) { return 1 + 9 * x.x; };
  for (const VertId v : IdRange<VertId>(f.hessian.size()))
    f.hessian[idx(v)] = k(f.dist.mesh.coords[v]) * SymTensor{-8, 0, 2, 0, 0, 1};
  for (const double p : {1.0, 2.0, kInf}) {
    static_cast<void>(hessian_metric(world(), f.dist, 3000, p, 0, kInf, f.hessian, f.metric));
    const double power = std::isinf(p) ? 3 : 3 * 2 * p / (2 * p + 3);
    const auto law = [&](VertId v) { return det(f.metric[idx(v)]) / std::pow(k(f.dist.mesh.coords[v]), power); };
    for (const VertId v : IdRange<VertId>(f.metric.size())) {
      EXPECT_NEAR(law(v) / law(VertId{0}), 1, 1e-9);
      EXPECT_NEAR(f.metric[idx(v)].xx / f.metric[idx(v)].zz, 8, 1e-9);
    }
  }
}

TEST(HessianMetric, the_unit_of_the_solution_does_not_matter) {
  Fixture f;
  auto other = f.metric;
  static_cast<void>(hessian_metric(world(), f.dist, 2000, 2, 0.01, 0.5, f.hessian, f.metric));
  for (auto& h : f.hessian) h = 1e-9 * h;
  static_cast<void>(hessian_metric(world(), f.dist, 2000, 2, 0.01, 0.5, f.hessian, other));
  for (std::size_t i = 0; i < other.size(); ++i) EXPECT_NEAR(other[i].xx / f.metric[i].xx, 1, 1e-9);
}

TEST(HessianMetric, a_linear_solution_gives_a_uniform_mesh) {
  Fixture f;
  const std::vector<SymTensor> none(f.hessian.size());
  static_cast<void>(hessian_metric(world(), f.dist, 8000, 2, 0, kInf, none, f.metric));
  for (const auto& m : f.metric) EXPECT_NEAR(m.xx, 400, 1e-6);
}

TEST(HessianMetric, number_of_ranks_changes_rounding_only) {
  const DealtCube cube{7, 0.1};
  const auto run = [&](const Comm& comm) {
    const DistMesh dist = cube.part(comm);
    const auto f = [](Vec3 x) { return std::tanh(20 * (x.x + 0.3 * x.y - 0.6)); };
    const auto h = recover_hessian(comm, dist, Halo(comm, dist.sharing), sample(dist, f));
    std::vector<SymTensor> metric(h.size());
    static_cast<void>(hessian_metric(comm, dist, 500, 2, 0.001, 1, h, metric));
    return std::pair(dist.vert2gid, metric);
  };
  const auto alone = run(Comm::self()), mine = run(world());
  for (const VertId v : IdRange<VertId>(mine.second.size())) {
    const auto &a = alone.second[idx(mine.first[v])], &b = mine.second[idx(v)];
    for (const Vec3 e : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 1}})
      EXPECT_NEAR(quad(b, e) / quad(a, e), 1, 1e-6);
  }
}

TEST(HessianMetric, options_out_of_range_are_refused) {
  Fixture f;
  const auto run = [&](double c, double p, double lo, double hi) {
    static_cast<void>(hessian_metric(world(), f.dist, c, p, lo, hi, f.hessian, f.metric));
  };
  EXPECT_THROW(run(0, 2, 0, 1), AgreedError);
  EXPECT_THROW(run(100, 0.5, 0, 1), AgreedError);
  EXPECT_THROW(run(100, 2, 1, 0.5), AgreedError);
  if (world().is_root()) f.hessian[0].xy = kInf;
  EXPECT_THROW(run(100, 2, 0, 1), AgreedError);
}

}  // namespace
}  // namespace skein
