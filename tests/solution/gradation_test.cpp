// Gradation: the bound holds on every edge, nothing becomes coarser, and the ranks do not matter.
#include "solution/gradation.hpp"

#include <gtest/gtest.h>

#include "metric/gradation.hpp"
#include "tests/support/dealt_cube.hpp"

namespace skein {
namespace {

using test::DealtCube;
using test::sample;
using test::world;

constexpr double kGrowth = 1.3;

/// Calls visit(v, w, vector from v to w) for both directions of every local edge.
template <class Visit>
void for_each_edge(const DistMesh& dist, Visit visit) {
  for (const auto& t : dist.mesh.tet2vert) {
    for (const VertId v : t) {
      for (const VertId w : t) {
        if (v != w) visit(v, w, dist.mesh.coords[w] - dist.mesh.coords[v]);
      }
    }
  }
}

/// Tiny at two spots, one of them on the line where four ranks meet; coarse elsewhere.
double spots(Vec3 x) {
  const double a = norm(x - Vec3{0.5, 0.5, 0.2}), b = norm(x - Vec3{0, 1, 1});
  return a < 0.1 ? 0.003 : b < 0.1 ? 0.001 : 1;
}

/// Flat in a direction that turns with z; strongly so near a plane.
SymTensor layer(Vec3 x) {
  const double c = std::cos(x.z), s = std::sin(x.z), d = std::abs(c * (x.x - 0.5) + s * (x.y - 0.5));
  Eigen e{{1, 4, d < 0.15 ? 1e6 : 9}, {Vec3{-s, c, 0}, Vec3{0, 0, 1}, Vec3{c, s, 0}}};
  return compose(e);
}

std::vector<SymTensor> layers(const DistMesh& dist) {
  std::vector<SymTensor> m;
  for (const Vec3 x : dist.mesh.coords) m.push_back(layer(x));
  return m;
}

struct Sizes {
  DistMesh dist;
  std::vector<double> before, after;
  GradationReport report;
};
template <class F>
Sizes graded_sizes(const Comm& comm, const DealtCube& cube, double growth, F f) {
  Sizes s{cube.part(comm), {}, {}, {}};
  s.before = s.after = sample(s.dist, f);
  s.report = grade_sizes(comm, s.dist, Halo(comm, s.dist.sharing), growth, s.after);
  return s;
}

TEST(GradeSizes, bounds_growth_on_every_edge_and_makes_nothing_coarser) {
  const auto s = graded_sizes(world(), DealtCube{12, 0.2}, kGrowth, spots);
  for_each_edge(s.dist, [&](VertId v, VertId w, Vec3 e) {
    const double h = s.after[idx(v)], slope = std::log(kGrowth);
    EXPECT_LE(s.after[idx(w)], (h + slope * norm(e)) * (1 + 1e-15));
    EXPECT_LE(s.after[idx(w)], h * std::pow(kGrowth, norm(e) / h) * (1 + 1e-12));
  });
  for (std::size_t i = 0; i < s.after.size(); ++i) {
    EXPECT_LE(s.after[i], s.before[i]);
    EXPECT_GE(s.after[i], 0.001);
  }
  EXPECT_GT(s.report.lowered, s.dist.global_verts / 2);
  EXPECT_TRUE(s.report.converged);
}

TEST(GradeSizes, number_of_ranks_does_not_change_a_bit) {
  const DealtCube cube{12, 0.2};
  const auto alone = graded_sizes(Comm::self(), cube, kGrowth, spots),
             mine = graded_sizes(world(), cube, kGrowth, spots);
  for (const VertId v : IdRange<VertId>(mine.after.size()))
    EXPECT_EQ(mine.after[idx(v)], alone.after[idx(mine.dist.vert2gid[v])]);
  EXPECT_EQ(mine.report.lowered, alone.report.lowered);
}

TEST(GradeSizes, keeps_what_is_graded_already) {
  const auto s =
      graded_sizes(world(), DealtCube{8, 0.2}, kGrowth, [](Vec3 x) { return 0.1 + 0.99 * std::log(kGrowth) * x.x; });
  EXPECT_EQ(s.after, s.before);
  EXPECT_EQ(s.report.lowered, 0);
  auto again = graded_sizes(world(), DealtCube{8, 0.2}, kGrowth, spots);
  const auto once = again.after;
  static_cast<void>(grade_sizes(world(), again.dist, Halo(world(), again.dist.sharing), kGrowth, again.after));
  EXPECT_EQ(again.after, once);
}

TEST(GradeSizes, ranks_without_tetrahedra_are_fine) {
  const auto s =
      graded_sizes(world(), DealtCube{1, 0}, kGrowth, [](Vec3 x) { return x.x + x.y + x.z < 0.5 ? 0.01 : 10; });
  for_each_edge(s.dist, [&](VertId v, VertId w, Vec3 e) {
    EXPECT_LE(s.after[idx(w)], s.after[idx(v)] + std::log(kGrowth) * norm(e) + 1e-15);
  });
}

TEST(GradeSizes, bad_input_is_refused_on_all_ranks) {
  const DistMesh dist = DealtCube{3, 0}.part(world());
  const Halo halo(world(), dist.sharing);
  std::vector<double> h(dist.mesh.vert_slots(), 1);
  EXPECT_THROW(static_cast<void>(grade_sizes(world(), dist, halo, 1, h)), AgreedError);
  if (world().is_root()) h[0] = 0;
  EXPECT_THROW(static_cast<void>(grade_sizes(world(), dist, halo, 1.5, h)), AgreedError);
}

struct Metrics {
  DistMesh dist;
  std::vector<SymTensor> before, after;
  GradationReport report;
};
Metrics graded_metric(const Comm& comm, const DealtCube& cube, double growth) {
  Metrics m{cube.part(comm), {}, {}, {}};
  m.before = m.after = layers(m.dist);
  m.report = grade_metric(comm, m.dist, growth, m.after);
  return m;
}

TEST(GradeMetric, bounds_growth_in_every_direction_on_every_edge) {
  const auto m = graded_metric(world(), DealtCube{10, 0.2}, kGrowth);
  EXPECT_TRUE(m.report.converged);
  EXPECT_GT(m.report.lowered, m.dist.global_verts / 4);
  const std::array<Vec3, 6> directions{Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, -2, 1}, {0.3, 1, -1}};
  for_each_edge(m.dist, [&](VertId v, VertId w, Vec3 e) {
    const SymTensor& from = m.after[idx(v)];
    for (const Vec3 d : directions) {
      const double growth = std::sqrt(quad(from, d) / quad(m.after[idx(w)], d));
      EXPECT_LE(growth, (1 + std::log(kGrowth) * std::sqrt(quad(from, e))) * (1 + kGradationTolerance));
    }
  });
}

TEST(GradeMetric, makes_nothing_coarser_and_repeats_itself) {
  auto m = graded_metric(world(), DealtCube{8, 0.2}, kGrowth);
  for (std::size_t i = 0; i < m.after.size(); ++i) {
    for (const Vec3 d : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 0}, Vec3{1, -2, 1}})
      EXPECT_GE(quad(m.after[i], d), quad(m.before[i], d) * (1 - 1e-9));
  }
  const auto once = m.after;
  const auto again = grade_metric(world(), m.dist, kGrowth, m.after);
  EXPECT_EQ(m.after, once);
  EXPECT_EQ(again.lowered, 0);
  std::vector<SymTensor> uniform(once.size(), SymTensor{5, 1, 7, 0.5, 0, 1e4});
  const auto same = uniform;
  static_cast<void>(grade_metric(world(), m.dist, 1.01, uniform));
  EXPECT_EQ(uniform, same);
}

TEST(GradeMetric, number_of_ranks_does_not_change_a_bit) {
  const DealtCube cube{10, 0.2};
  const auto alone = graded_metric(Comm::self(), cube, kGrowth), mine = graded_metric(world(), cube, kGrowth);
  for (const VertId v : IdRange<VertId>(mine.after.size()))
    EXPECT_EQ(mine.after[idx(v)], alone.after[idx(mine.dist.vert2gid[v])]);
  EXPECT_EQ(mine.report.sweeps, alone.report.sweeps);
  EXPECT_EQ(mine.report.lowered, alone.report.lowered);
}

TEST(GradeMetric, of_an_isotropic_metric_is_that_of_the_sizes) {
  const auto s = graded_sizes(world(), DealtCube{10, 0.2}, kGrowth, spots);
  std::vector<SymTensor> m;
  for (const double h : s.before) m.push_back(isotropic(1 / (h * h)));
  static_cast<void>(grade_metric(world(), s.dist, kGrowth, m));
  for (std::size_t i = 0; i < m.size(); ++i)
    EXPECT_NEAR(1 / std::sqrt(m[i].xx) / s.after[i], 1, 20 * kGradationTolerance);
}

}  // namespace
}  // namespace skein
