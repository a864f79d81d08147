// adapt_local: one rank's mesh by several threads.
#include "adapt/local.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "tests/kernel/metrics.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::test {
namespace {

struct Outcome {
  TetMesh mesh;
  LocalResult result;
  Measures before;
};

SmoothMetric layered(double scale) {
  SmoothMetric m;
  m.size = {0.05 * scale, 0.11 * scale, 0.11 * scale};
  m.slope = {Vec3{1, 0, 0}, Vec3{0, 0.5, 0}, Vec3{}};
  m.turn = {0.4, 0.3, 0};
  return m;
}

/// A mesh large enough that threads get to work: 2,000 tetrahedra each, in builds for debugging for two of them.
#ifdef __OPTIMIZE__
constexpr int kCells = 12;
#else
constexpr int kCells = 10;  // even, for two regions
#endif
Outcome run(int threads, bool regions, Shape shape = Shape::kBox, bool frozen = false,
            int smallest_band = Method{}.threads.smallest_band, double scale = 1) {
  Outcome r;
  r.mesh = make_mesh({.n = kCells, .shape = shape, .two_regions = regions, .perturb = 0.2});
  for (const VertId v : IdRange<VertId>(r.mesh.vert_slots())) {
    if (frozen && r.mesh.coords[v].z == 0) r.mesh.vert_state[v] |= kFrozen;
  }
  compact(r.mesh);
  set_metric(r.mesh, layered(scale));
  r.before = measure(r.mesh);
  LocalOptions options;
  options.threads = threads;
  options.kernel.method.threads.smallest_band = smallest_band;
  r.result = adapt_local(r.mesh, options);
  return r;
}

struct Fit {
  double unit_share = 0, worst = 1, mean = 0;
};
Fit fit(const Outcome& r) {
  Fit out;
  std::set<std::pair<VertId, VertId>> edges;
  for (const TetId t : IdRange<TetId>(r.mesh.tet_slots())) {
    const auto& v = r.mesh.tet2vert[t];
    const auto x = [&](std::size_t i) { return r.mesh.coords[v[i]]; };
    const auto m = [&](std::size_t i) -> const VertMetric& { return r.mesh.metric[v[i]]; };
    const double q = quality(quality_cubed(x(0), x(1), x(2), x(3), m(0), m(1), m(2), m(3)));
    out.worst = std::min(out.worst, q);
    out.mean += q / static_cast<double>(r.mesh.tet_slots());
    for (const auto& e : kEdgeVerts) {
      edges.insert(std::minmax(v[e[0]], v[e[1]]));
    }
  }
  std::size_t unit = 0;
  for (const auto& [a, b] : edges) {
    const double l = edge_length(r.mesh.metric[a].m, r.mesh.metric[b].m, r.mesh.coords[b] - r.mesh.coords[a]);
    unit += l > std::sqrt(0.5) && l < std::sqrt(2.0);
  }
  out.unit_share = 100.0 * static_cast<double>(unit) / static_cast<double>(edges.size());
  return out;
}

class Threads : public ::testing::TestWithParam<int> {};

TEST_P(Threads, GiveAValidMeshThatFits) {
  const Fit alone = fit(run(1, false));
  for (const bool regions : {false, true}) {
    const Outcome r = run(GetParam(), regions);
    ASSERT_EQ(check(r.mesh), "");
    EXPECT_TRUE(interface_faces(r.mesh).empty());
    EXPECT_EQ(differ(r.before, measure(r.mesh), 1e-12), "");
    EXPECT_EQ(r.mesh.metric.size(), r.mesh.vert_slots());
    EXPECT_EQ(count_tets(r.mesh), r.mesh.tet_slots());
    const Fit f = fit(r);
    EXPECT_GE(f.unit_share, 90);
    EXPECT_GE(f.worst, 0.1);
    if (regions) continue;
    EXPECT_GE(f.unit_share, alone.unit_share - 2);
    EXPECT_GE(f.mean, alone.mean - 0.02);
  }
}

TEST_P(Threads, GiveTheSameBytesAgain) {
  const Outcome a = run(GetParam(), true), b = run(GetParam(), true);
  EXPECT_EQ(a.mesh.tet2vert, b.mesh.tet2vert);
  EXPECT_EQ(a.mesh.tet2face, b.mesh.tet2face);
  EXPECT_EQ(a.mesh.face_tag, b.mesh.face_tag);
  EXPECT_EQ(a.mesh.coords, b.mesh.coords);
  EXPECT_EQ(a.mesh.vert_class, b.mesh.vert_class);
  EXPECT_EQ(a.mesh.vert_state, b.mesh.vert_state);
  EXPECT_EQ(a.mesh.log_metric, b.mesh.log_metric);
}

TEST_P(Threads, LeaveFrozenVerticesAndTellTheirNumbers) {
  const TetMesh before = [] {
    TetMesh m = make_mesh({.n = kCells, .perturb = 0.2});
    compact(m);
    return m;
  }();
  const Outcome r = run(GetParam(), false, Shape::kBox, true);
  ASSERT_EQ(check(r.mesh), "");
  ASSERT_EQ(r.result.old2new.size(), before.vert_slots());
  for (const VertId v : IdRange<VertId>(before.vert_slots())) {
    const VertId now = r.result.old2new[v];
    ASSERT_EQ(now != kNoVert, before.coords[v].z == 0);
    if (now == kNoVert) continue;
    EXPECT_EQ(r.mesh.coords[now], before.coords[v]);
    EXPECT_TRUE(r.mesh.has(now, kFrozen));
  }
  for (const VertId v : IdRange<VertId>(r.mesh.vert_slots())) {  // and no others
    EXPECT_TRUE(!r.mesh.has(v, kFrozen) || r.mesh.coords[v].z == 0);
  }
}

TEST_P(Threads, KeepCurvedPatches) {
  const Outcome r = run(GetParam(), false, Shape::kCylinder);
  ASSERT_EQ(check(r.mesh), "");
  const Measures after = measure(r.mesh);
  EXPECT_EQ(after.fixed, r.before.fixed);
  EXPECT_NEAR(after.volume, r.before.volume, 0.01 * r.before.volume);
}

/// Bands are small against a mesh of this size, and are cut however small they are.
TEST(Slabs, ShareTheBandBetweenBlocks) {
  const auto made = [](int smallest_band) { return run(2, true, Shape::kBox, true, smallest_band, 0.55); };
  const Outcome whole = made(Method{}.threads.smallest_band), a = made(1), b = made(1);
  ASSERT_EQ(check(a.mesh), "");
  EXPECT_TRUE(interface_faces(a.mesh).empty());
  EXPECT_EQ(differ(a.before, measure(a.mesh), 1e-12), "");
  EXPECT_EQ(count_tets(a.mesh), a.mesh.tet_slots());
  for (const VertId v : IdRange<VertId>(a.mesh.vert_slots())) {
    EXPECT_TRUE(!a.mesh.has(v, kFrozen) || a.mesh.coords[v].z == 0);
  }
  const Fit cut = fit(a), uncut = fit(whole);
  EXPECT_GE(cut.unit_share, uncut.unit_share - 0.5);
  EXPECT_GE(cut.mean, uncut.mean - 0.005);
  EXPECT_GE(cut.worst, 0.1);
  EXPECT_NE(a.mesh.coords, whole.mesh.coords);  // they have really been cut
  EXPECT_EQ(a.mesh.tet2vert, b.mesh.tet2vert);
  EXPECT_EQ(a.mesh.coords, b.mesh.coords);
}

INSTANTIATE_TEST_SUITE_P(Counts, Threads, ::testing::Values(1, 2, 3, 4));

}  // namespace
}  // namespace skein::test
