// adapt() on several ranks and threads: valid, everything kept, fits the metric, as good as on one rank, the same
// bytes.
#include <gtest/gtest.h>

#include <functional>

#include "adapt/adapt.hpp"
#include "base/tensor.hpp"
#include "report/statistics.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// Sizes in three fixed directions, at a place.
using LogMetric = std::function<SymTensor(Vec3)>;

SymTensor sizes(double hx, double hy, double hz) {
  return {-2 * std::log(hx), 0, -2 * std::log(hy), 0, 0, -2 * std::log(hz)};
}
LogMetric uniform(double h) {
  return [h](Vec3) { return sizes(h, h, h); };
}
/// Thin across the plane x = 1/2.
SymTensor planar(Vec3 x) { return sizes(0.025 + 0.3 * std::abs(x.x - 0.5), 0.15, 0.15); }
/// Thin across the cylinder r = 0.6 about the z axis.
SymTensor cylindrical(Vec3 x) {
  const double r = std::sqrt(x.x * x.x + x.y * x.y);
  const double thin = -2 * std::log(0.03 + 0.3 * std::abs(r - 0.6)), wide = -2 * std::log(0.15);
  if (r < 1e-9) return {wide, 0, wide, 0, 0, wide};
  const double c = x.x / r, s = x.y / r;
  return {thin * c * c + wide * s * s, (thin - wide) * c * s, thin * s * s + wide * c * c, 0, 0, wide};
}

struct Case {
  const char* name;
  int n;  ///< cells per axis
  bool regions;
  LogMetric metric;
};
std::vector<Case> cases(int threads = 1) {
  // Threads get to work on some thousands of tetrahedra each, so their mesh starts finer.
  if (threads > 1) return {{"threads", 12, true, planar}, {"coarsening", 12, false, uniform(0.14)}};
  return {{"uniform", 6, false, uniform(0.09)},
          {"planar", 6, false, planar},
          {"cylindrical", 6, false, cylindrical},
          {"coarsening", 12, false, uniform(0.14)},
          {"regions", 6, true, uniform(0.09)}};
}

DistMesh make(const Comm& comm, const Case& c) {
  return with_metric(comm, cube(c.n, c.regions ? Regions::kTwoTagged : Regions::kOne), c.metric);
}

void run(const Comm& comm, DistMesh& dist, int threads, bool surface = true) {
  AdaptOptions options;
  options.threads = threads;
  options.surface = surface;
  PhaseLog log(comm, PhaseLog::Output::kQuiet);
  adapt(comm, dist, options, log);
}

/// What one rank and one thread make of it; computed on rank 0 alone.
struct Reference {
  double unit_share, quality_mean, tets;
};
Reference reference(const Comm& comm, const Case& c) {
  Reference r{};
  if (comm.is_root()) {
    const Comm self = Comm::self();
    DistMesh dist = make(self, c);
    run(self, dist, 1);
    const MeshStatistics s = statistics(self, dist, skein::Measure::kInMetric);
    r = {s.length.unit_share, s.quality.mean, static_cast<double>(s.tets)};
  }
  return comm.broadcast(r);
}

void expect_kept(const Measure& before, const Measure& after) {
  EXPECT_NEAR(after.volume, before.volume, 1e-12);
  EXPECT_NEAR(after.feature_length, before.feature_length, 1e-11);
  EXPECT_EQ(after.area.size(), before.area.size());
  for (const auto& [ref, area] : before.area) {
    EXPECT_NEAR(after.area.count(ref) == 1 ? after.area.at(ref) : 0, area, 1e-11) << "patch " << ref;
  }
}

class Adapt : public ::testing::TestWithParam<int> {};  // threads

TEST_P(Adapt, KeepsAndFits) {
  const Comm& comm = world();
  for (const Case& c : cases(GetParam())) {
    SCOPED_TRACE(c.name);
    DistMesh dist = make(comm, c);
    const Measure before = measure(comm, dist);
    const Content corners_before = content(comm, to_slices(comm, dist));
    run(comm, dist, GetParam());
    EXPECT_NO_THROW(reconcile(comm, dist));
    EXPECT_EQ(check(dist.mesh), "");
    expect_kept(before, measure(comm, dist));
    EXPECT_EQ(content(comm, to_slices(comm, dist)).corners, corners_before.corners);
    for (const VertState s : dist.mesh.vert_state) EXPECT_FALSE(any(s & kActive));
    const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric);
    EXPECT_EQ(s.nonpositive_tets, 0);
    EXPECT_GE(s.length.unit_share, 90);
    EXPECT_LE(s.length.p99, 2);
    // The worst element and the longest edge; a part of a few hundred tetrahedra is little more than its interface.
    if (s.tets >= 1000 * comm.size()) {
      EXPECT_GE(s.quality.min, 0.2);
      EXPECT_LE(s.length.max, 2.5);
      EXPECT_GE(s.length.min, 0.25);
    }
    EXPECT_GE(s.length.p1, 0.5);
    const Reference one = reference(comm, c);
    EXPECT_GE(s.length.unit_share, one.unit_share - 2);
    EXPECT_GE(s.quality.mean, one.quality_mean - 0.02);
    EXPECT_NEAR(static_cast<double>(s.tets), one.tets, 0.1 * one.tets);
  }
}

/// FNV-1a over all that is written.
std::uint64_t hash(const Comm& comm, const DistMesh& dist) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  const auto add = [&](const auto& v) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(v.data());
    for (std::size_t i = 0; i < v.size() * sizeof(v[0]); ++i) h = (h ^ bytes[i]) * 0x100000001b3ULL;
  };
  const MeshSlice m = to_slices(comm, dist);
  add(m.coords);
  add(m.vert_ref);
  add(m.tets.verts);
  add(m.tets.ref);
  add(m.triangles.verts);
  add(m.triangles.ref);
  add(m.edges.verts);
  add(m.corners.verts);
  add(m.ridges.verts);
  add(dist.mesh.log_metric.raw());
  return h;
}

TEST_P(Adapt, GivesTheSameBytesAgain) {
  const Comm& comm = world();
  const auto once = [&] {
    DistMesh dist = make(comm, cases(GetParam())[0]);
    run(comm, dist, GetParam());
    return hash(comm, dist);
  };
  EXPECT_EQ(once(), once());
}

TEST_P(Adapt, KeepsTheSurfaceTriangulationWhenAsked) {
  const Comm& comm = world();
  DistMesh dist = make(comm, {"surface", 6, true, uniform(0.1)});
  const Content before = content(comm, to_slices(comm, dist));
  run(comm, dist, GetParam(), false);
  EXPECT_NO_THROW(reconcile(comm, dist));
  EXPECT_EQ(check(dist.mesh), "");
  const Content after = content(comm, to_slices(comm, dist));
  EXPECT_EQ(after.tris, before.tris);
  EXPECT_EQ(after.edges, before.edges);
}

TEST_P(Adapt, AnOutputIsAsGoodAnInputAsAny) {
  const Comm& comm = world();
  DistMesh dist = make(comm, cases(GetParam())[0]);
  run(comm, dist, GetParam());
  const std::int64_t first = dist.global_tets;
  run(comm, dist, GetParam());
  EXPECT_NO_THROW(reconcile(comm, dist));
  const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric);
  EXPECT_GE(s.length.unit_share, 90);
  EXPECT_NEAR(static_cast<double>(dist.global_tets), static_cast<double>(first), 0.05 * static_cast<double>(first));
}

TEST_P(Adapt, WorksWithFewerTetrahedraThanRanks) {
  const Comm& comm = world();
  DistMesh dist = make(comm, {"tiny", 1, false, uniform(0.3)});
  const Measure before = measure(comm, dist);
  run(comm, dist, GetParam());
  EXPECT_NO_THROW(reconcile(comm, dist));
  EXPECT_EQ(check(dist.mesh), "");
  expect_kept(before, measure(comm, dist));
  EXPECT_LE(statistics(comm, dist, skein::Measure::kInMetric).length.max, 4);
}

TEST(AdaptBalance, GivesEveryRankItsShareOfTheResult) {
  const Comm& comm = world();
  const auto graded = [](Vec3 x) { return sizes(0.01 + 0.2 * std::abs(x.x - 0.3), 0.05, 0.05); };
  DistMesh dist = make(comm, {"graded", 8, false, graded});
  const Measure before = measure(comm, dist);
  run(comm, dist, 1);
  EXPECT_NO_THROW(reconcile(comm, dist));
  EXPECT_EQ(check(dist.mesh), "");
  expect_kept(before, measure(comm, dist));
  const double mean = static_cast<double>(dist.global_tets) / comm.size();
  EXPECT_LE(static_cast<double>(comm.max(static_cast<std::int64_t>(dist.mesh.tet_slots()))), 1.05 * mean);
}

TEST(AdaptGrowth, OfSeveralThreadsIsAsGoodAsOfOne) {
  const Comm& comm = world();
  const Case c{"grows", 12, false, uniform(0.05)};  // can be cut for two, wants four
  const Reference one = reference(comm, c);
  DistMesh dist = make(comm, c);
  run(comm, dist, 4);
  EXPECT_NO_THROW(reconcile(comm, dist));
  const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric);
  EXPECT_GE(s.length.unit_share, one.unit_share - 2);
  EXPECT_NEAR(static_cast<double>(s.tets), one.tets, 0.05 * one.tets);
}

INSTANTIATE_TEST_SUITE_P(Threads, Adapt, ::testing::Values(1, 2));

}  // namespace
}  // namespace skein::test
