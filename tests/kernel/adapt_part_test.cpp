// adapt_part: the recipe keeps what the operators keep, and the result fits the metric.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

#include "kernel/recipe.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "tests/kernel/judge.hpp"
#include "tests/kernel/metrics.hpp"

namespace skein::test {
namespace {

/// Share of edges with both ends free that are not longer than sqrt 2, not shorter than 1/sqrt 2; the longest; worst Q.
struct Fit {
  double unit_share = 0, above_two = 0, longest = 0, worst = 1;
  std::size_t tets = 0;
};
Fit fit(const Part& p) {
  Fit out;
  std::set<std::pair<VertId, VertId>> edges;
  for (const TetId t : IdRange<TetId>(p.mesh.tet_slots())) {
    if (!p.mesh.is_live(t)) continue;
    ++out.tets;
    out.worst = std::min(out.worst, quality(quality_cubed(p, t)));
    for (const auto& e : kEdgeVerts) {
      edges.insert(std::minmax(p.mesh.tet2vert[t][e[0]], p.mesh.tet2vert[t][e[1]]));
    }
  }
  std::size_t unit = 0, above_two = 0;
  for (const auto& [a, b] : edges) {
    const double l = p.length(a, b);
    unit += l > std::sqrt(0.5) && l < std::sqrt(2.0);
    above_two += l > 2;
    out.longest = std::max(out.longest, l);
  }
  out.unit_share = static_cast<double>(unit) / static_cast<double>(edges.size());
  out.above_two = static_cast<double>(above_two) / static_cast<double>(edges.size());
  return out;
}

Part make_part(const MeshSpec& spec, const SmoothMetric& metric) {
  Part p;
  p.mesh = make_mesh(spec);
  set_metric(p.mesh, metric);
  prepare(p);
  return p;
}

RC_GTEST_PROP(AdaptPart, KeepsFlatSidedMeshesInAnyMetric, ()) {
  MeshSpec spec;
  spec.two_regions = *rc::gen::arbitrary<bool>();
  spec.n = spec.two_regions ? *rc::gen::element(2, 4) : *rc::gen::inRange(1, 5);
  spec.shape = *rc::gen::element(Shape::kBox, Shape::kSkewed);
  spec.required = *rc::gen::element(false, false, true);
  spec.perturb = *rc::gen::element(0.0, 0.3);
  spec.seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  Part p = make_part(spec, random_smooth_metric(random, 0.06, 0.6, 1));
  p.options.method.points = *rc::gen::element(PointCreation::kEdges, PointCreation::kEdges, PointCreation::kCentroids);
  p.options.method.smoothing = *rc::gen::element(Smoothing::kQuality, Smoothing::kQuality, Smoothing::kSprings);
  const Measures before = measure(p.mesh);
  adapt_part(p);
  RC_ASSERT(judge(p) == "");
  RC_ASSERT(differ(before, measure(p.mesh), 1e-12) == "");
}

/// What must stay, by coordinates, since the part may be renumbered.
using Items = std::multiset<std::vector<double>>;
Items frozen_vertices(const Part& p) {
  Items out;
  for (const VertId v : IdRange<VertId>(p.mesh.vert_slots())) {
    if (!p.mesh.is_live(v) || !p.mesh.has(v, kFrozen)) continue;
    const Vec3 x = p.x(v);
    const SymTensor& l = p.mesh.log_metric[v];
    const VertState state = p.mesh.vert_state[v] & ~(kBesideFrozen | kRetry);
    out.insert({x.x, x.y, x.z, l.xx, l.xy, l.yy, l.xz, l.yz, l.zz, double(p.mesh.vert_class[v]), double(state)});
  }
  return out;
}
std::vector<double> place(const TetMesh& m, const std::array<VertId, 3>& face) {
  std::vector<std::array<double, 3>> x;
  for (const VertId v : face) x.push_back({m.coords[v].x, m.coords[v].y, m.coords[v].z});
  std::sort(x.begin(), x.end());
  return {x[0][0], x[0][1], x[0][2], x[1][0], x[1][1], x[1][2], x[2][0], x[2][1], x[2][2]};
}
Items interface_of(const TetMesh& m) {
  Items out;
  for (const auto& f : interface_faces(m)) out.insert(place(m, f));
  return out;
}
Items tagged_faces(const TetMesh& m) {
  Items out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (int f = 0; m.is_live(t) && f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f];
      if (tag == 0) continue;
      auto item = place(m, m.verts(make_face(t, f)));
      item.push_back(tag);
      out.insert(item);
    }
  }
  return out;
}

Items all_tets(const TetMesh& m) {
  Items out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    std::vector<double> item;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto x = place(m, m.verts(make_face(t, f)));
      item.insert(item.end(), x.begin(), x.end());
    }
    out.insert(item);
  }
  return out;
}

RC_GTEST_PROP(AdaptPart, LeavesFrozenVerticesAndInterfaces, ()) {
  MeshSpec spec;
  spec.n = *rc::gen::inRange(2, 5);
  spec.perturb = 0.2;
  spec.seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  const TetMesh whole = make_mesh(spec);
  IdVector<TetId, int> label(whole.tet_slots());
  for (auto& l : label) l = static_cast<int>(random() % 2);  // as ragged as can be
  if (*rc::gen::arbitrary<bool>()) {
    for (std::size_t t = 0; t < label.size(); ++t) label.raw()[t] = 3 * t > label.size() ? 1 : 0;
  }
  Part p;
  IdVector<VertId, GlobalId> gid;
  p.mesh = cut_out(whole, label, 1, gid);
  set_metric(p.mesh, random_smooth_metric(random, 0.08, 0.6, 1));
  prepare(p);
  const Snapshot before(p);
  const Items frozen = frozen_vertices(p);
  adapt_part(p);
  RC_ASSERT(judge(p) == "");
  RC_ASSERT(differ(measure(before.mesh), measure(p.mesh), 1e-12) == "");
  RC_ASSERT(interface_of(p.mesh) == interface_of(before.mesh));
  RC_ASSERT(frozen_vertices(p) == frozen);
}

RC_GTEST_PROP(AdaptPart, KeepsTheSurfaceWhenAsked, ()) {
  MeshSpec spec;
  spec.two_regions = *rc::gen::arbitrary<bool>();
  spec.n = spec.two_regions ? *rc::gen::element(2, 4) : *rc::gen::inRange(1, 4);
  spec.shape = *rc::gen::element(Shape::kBox, Shape::kCylinder, Shape::kSphere);
  spec.perturb = 0.2;
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  Part p = make_part(spec, random_smooth_metric(random, 0.15, 0.8, 1));
  p.options.surface = SurfaceChange::kNone;
  const Snapshot before(p);
  adapt_part(p);
  RC_ASSERT(judge(p) == "");
  RC_ASSERT(tagged_faces(p.mesh) == tagged_faces(before.mesh));
  RC_ASSERT(differ(measure(before.mesh), measure(p.mesh), 1e-12) == "");
}

/// Where the surface may not follow the metric, there is always room for another point nearer to it.
class KeptSurface : public ::testing::TestWithParam<double> {};
TEST_P(KeptSurface, GetsNoFlatElements) {
  SmoothMetric metric;
  metric.size = {GetParam(), GetParam(), GetParam()};
  for (const bool frozen : {false, true}) {
    Part p = make_part({.n = 6, .perturb = 0.2}, metric);
    p.options.surface = frozen ? SurfaceChange::kAllowed : SurfaceChange::kNone;
    for (const VertId v : IdRange<VertId>(p.mesh.vert_slots())) {
      if (frozen && p.x(v).z == 0) p.mesh.vert_state[v] |= kFrozen;
    }
    adapt_part(p);
    ASSERT_EQ(judge(p), "");
    EXPECT_GE(fit(p).worst, 0.1);
  }
}
INSTANTIATE_TEST_SUITE_P(Sizes, KeptSurface, ::testing::Values(0.1, 0.07, 0.05, 0.04));

RC_GTEST_PROP(AdaptPart, StaysOnCurvedPatches, ()) {
  MeshSpec spec;
  spec.shape = *rc::gen::element(Shape::kCylinder, Shape::kSphere);
  spec.n = *rc::gen::inRange(4, 7);
  spec.perturb = 0.2;
  spec.seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  Part p = make_part(spec, random_smooth_metric(random, 0.15, 0.8, 0.5));
  const Measures before = measure(p.mesh);
  adapt_part(p);
  RC_ASSERT(judge(p) == "");
  const Measures after = measure(p.mesh);
  RC_ASSERT(before.fixed == after.fixed);
  // How far an operation may leave the facets is 1 % of an edge, and all edges are shorter than the body; normals may
  // turn by 15 degrees, which changes an area by 1 - cos(15).
  RC_ASSERT(std::abs(after.volume - before.volume) < 0.01 * before.volume);
  for (const auto& [patch, area] : before.area_of) RC_ASSERT(std::abs(after.area_of.at(patch) - area) < 0.034 * area);
  for (const auto& [ref, length] : before.feature_of) {
    RC_ASSERT(std::abs(after.feature_of.at(ref) - length) < 0.01 * length);
  }
}

/// On a mesh of enough elements the result fits.
class Fits : public ::testing::TestWithParam<std::array<double, 3>> {};
TEST_P(Fits, TheMetric) {
  const auto h = GetParam();
  SmoothMetric metric;
  metric.size = h;
  metric.slope = {Vec3{0.5, 0, 0}, Vec3{0, 0.5, 0}, Vec3{0.5, 0, 0}};
  metric.turn = {0.5, 0.3, 0};
  for (const Shape shape : {Shape::kBox, Shape::kSkewed}) {
    Part p = make_part({.n = 6, .shape = shape, .perturb = 0.2}, metric);
    adapt_part(p);
    ASSERT_EQ(judge(p), "");
    const Fit f = fit(p);
    EXPECT_GE(f.unit_share, 0.9) << f.tets;
    EXPECT_GE(f.worst, 0.1) << f.tets;
    EXPECT_LE(f.above_two, 0.005) << f.tets;
    EXPECT_LE(f.longest, 5) << f.tets;
  }
}
INSTANTIATE_TEST_SUITE_P(Metrics, Fits,
                         ::testing::Values(std::array{0.08, 0.08, 0.08}, std::array{0.12, 0.12, 0.12},
                                           std::array{0.03, 0.15, 0.15}, std::array{0.06, 0.06, 0.25},
                                           std::array{0.03, 0.1, 0.2}));

/// The first step creates few points, and what it leaves long is for the second one.
TEST(AdaptPart, CreatesPointsInTwoSteps) {
  SmoothMetric metric;
  metric.size = {0.04, 0.04, 0.04};
  metric.turn = {0, 0, 0};
  Part p = make_part({.n = 5, .two_regions = true, .perturb = 0.2}, metric);
  const auto lengths = [&] { return std::pair{fit(p).unit_share, fit(p).above_two}; };
  const double long_before = lengths().second;
  create_coarse_points(p);
  ASSERT_EQ(judge(p), "");
  const std::int64_t coarse = p.counts.insert;
  const auto [unit, above_two] = lengths();
  EXPECT_GT(coarse, 0);
  EXPECT_GT(long_before, 0.99);
  EXPECT_LT(unit, 0.5);       // not the work of the second step
  EXPECT_GT(above_two, 0.1);  // between the bound of the second step and that of the first
  EXPECT_LT(fit(p).longest, 2 * p.options.method.lengths.first_step * p.options.method.lengths.split_above);
  adapt_part(p);
  ASSERT_EQ(judge(p), "");
  EXPECT_GT(p.counts.insert, 4 * coarse);
  EXPECT_GT(fit(p).unit_share, 0.95);
  EXPECT_EQ(fit(p).above_two, 0);
}

TEST(AdaptPart, RelaxesStrainedEdges) {
  SmoothMetric metric;
  metric.size = {0.03, 0.06, 0.12};
  const auto adapted = [&](bool relax) {
    Part p = make_part({.n = 4, .two_regions = true, .perturb = 0.2}, metric);
    p.options.lower_strain = relax;
    const Measures before = measure(p.mesh);
    adapt_part(p);
    EXPECT_EQ(judge(p), "");
    EXPECT_EQ(differ(before, measure(p.mesh), 1e-12), "");
    return fit(p);
  };
  const auto plain = adapted(false), relaxed = adapted(true);
  EXPECT_LT(1 - relaxed.unit_share, 0.75 * (1 - plain.unit_share));
  EXPECT_LE(relaxed.longest, std::max(2.2, plain.longest));
  EXPECT_GT(relaxed.worst, 0.2);
}

/// All that have a bit, in order, also what a visit adds behind them, unless it is beyond the end.
TEST(Dirty, IsVisitedWhereThereIsABit) {
  for (const std::size_t n : {0, 1, 7, 8, 9, 40}) {
    for (const bool to_the_end : {false, true}) {
      Part p;
      for (std::size_t i = 0; i < n; ++i) p.dirty.push_back(i % 3 == 0 ? kInsertPass : i % 11 == 5 ? kSwapPass : 0);
      std::vector<TetId> expected, visited;
      for (std::size_t i = 0; i < n; i += 3) expected.push_back(to_id<TetId>(i));
      std::size_t added = 0;
      for_each_dirty(p, kInsertPass, to_the_end ? n : 1000, [&](TetId t) {
        visited.push_back(t);
        p.dirty[t] = 0;
        if (added == 12) return;
        if (!to_the_end) expected.push_back(to_id<TetId>(p.dirty.size()));
        p.dirty.push_back(kInsertPass);
        ++added;
      });
      EXPECT_EQ(visited, expected) << n;
    }
  }
}

TEST(AdaptPart, GivesTheSameBytesAgain) {
  const auto run = [] {
    std::mt19937 random(7);
    Part p = make_part({.n = 4, .shape = Shape::kCylinder, .perturb = 0.2}, random_smooth_metric(random, 0.1, 0.3, 1));
    adapt_part(p);
    return p;
  };
  const Part a = run(), b = run();
  EXPECT_EQ(a.mesh.tet2vert, b.mesh.tet2vert);
  EXPECT_EQ(a.mesh.coords, b.mesh.coords);
  EXPECT_EQ(a.mesh.log_metric, b.mesh.log_metric);
}

/// Beside frozen edges that are far too long for the metric.
TEST(AdaptPart, MarksWhatFrozenVerticesLeaveBad) {
  for (const bool frozen : {true, false}) {
    SmoothMetric metric;
    metric.size = {0.06, 0.06, 0.06};
    Part p = make_part({.n = 4, .perturb = 0.2}, metric);
    for (const VertId v : IdRange<VertId>(p.mesh.vert_slots())) {
      p.mesh.vert_state[v] |= kRetry | kBesideFrozen;  // of an earlier round
      if (frozen && p.x(v).x == 0) p.mesh.vert_state[v] |= kFrozen;
    }
    adapt_part(p);
    IdVector<VertId, char> of_bad(p.mesh.vert_slots(), 0), of_poor(p.mesh.vert_slots(), 0);
    std::size_t bad = 0;
    for (const TetId t : IdRange<TetId>(p.mesh.tet_slots())) {
      if (!p.mesh.is_live(t)) continue;
      const auto& v = p.mesh.tet2vert[t];
      for (const VertId w : v)
        of_poor[w] |= p.has_any(t, kFrozen) && p.q3[t] < cube(p.options.method.retry.good_quality) ? 1 : 0;
      bool is_bad = quality(quality_cubed(p, t)) < 0.3;
      for (const auto& e : kEdgeVerts) {
        const double l = p.length(v[e[0]], v[e[1]]);
        is_bad = is_bad || l > 2 || l < 0.4;
      }
      if (!is_bad) continue;
      for (const VertId w : v) of_bad[w] = 1;
      if (!p.has_any(t, kFrozen)) continue;
      ++bad;
      for (const VertId w : v) EXPECT_TRUE(p.mesh.has(w, kRetry));
    }
    EXPECT_EQ(bad > 0, frozen);
    for (const VertId v : IdRange<VertId>(p.mesh.vert_slots())) {
      EXPECT_TRUE(!p.mesh.has(v, kRetry) || (frozen && of_bad[v] != 0));
      EXPECT_EQ(p.mesh.has(v, kBesideFrozen), p.mesh.is_live(v) && of_poor[v] != 0);
    }
  }
}

/// Thin across a cylinder about the z axis, of size 0.2 along it: an edge of that length spans ten layers.
struct LayerMetric {
  [[nodiscard]] SymTensor log_at(Vec3 x) const noexcept {
    const double r = std::max(std::hypot(x.x, x.y), 1e-12), c = x.x / r, s = x.y / r;
    Eigen e;
    e.vector = {Vec3{c, s, 0}, Vec3{-s, c, 0}, Vec3{0, 0, 1}};
    e.value = {-2 * std::log(0.004 + 0.392 * std::abs(r - 0.5)), -2 * std::log(0.2), -2 * std::log(0.2)};
    return compose(e);
  }
};

TEST(AdaptPart, FitsAMetricThatTurnsWithinItsElements) {
  const LayerMetric metric;
  Part p;
  p.mesh = make_mesh({.n = 3});
  const Measures before = measure(p.mesh);
  for (int pass = 0; pass < 6; ++pass) {
    set_metric(p.mesh, metric);
    prepare(p);
    adapt_part(p);
    EXPECT_EQ(p.quality_measure, QualityMeasure::kLargestMetric);
    EXPECT_TRUE(p.mesh.anchor.empty());
    EXPECT_EQ(judge(p), "");
    EXPECT_EQ(differ(before, measure(p.mesh), 1e-12), "");
    compact(p);
  }
  set_metric(p.mesh, metric);
  const Fit f = fit(p);
  EXPECT_GT(f.unit_share, 0.93) << f.tets;
  EXPECT_GT(f.worst, 0.25) << f.tets;
}

TEST(AdaptPart, WithoutActiveVerticesNothingChanges) {
  std::mt19937 random(3);
  Part p = make_part({.n = 4, .perturb = 0.2}, random_smooth_metric(random, 0.1, 0.3, 1));
  for (VertState& s : p.mesh.vert_state) s &= ~kActive;
  const Items before = all_tets(p.mesh);
  adapt_part(p);
  EXPECT_EQ(all_tets(p.mesh), before);
}

}  // namespace
}  // namespace skein::test
