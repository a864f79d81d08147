// Local sizes: the file, the bounds at vertices on any ranks, entities that are frozen; the mesh's own metric; sources.
#include "solution/local_sizes.hpp"

#include <gtest/gtest.h>

#include "metric/complexity.hpp"
#include "solution/demand.hpp"
#include "solution/local_file.hpp"
#include "solution/metric_policy.hpp"
#include "solution/own_metric.hpp"
#include "tests/generate/expect_error.hpp"
#include "tests/support/dealt_cube.hpp"
#include "tests/support/dist_meshes.hpp"

namespace skein {
namespace {

using test::expect_error;
using test::world;

constexpr const char* kGood = R"([names]
wing = [1, 2]
tail = 4
[[patch]]
name = "wing"
size = 0.1
[[patch]]
ref = 4
hmax = 0.5
freeze = true
[[region]]
ref = [7, 8]
hmin = 0.01
hmax = 2
)";

TEST(LocalFile, IsRead) {
  const auto rules = parse_local(kGood, "a.toml");
  ASSERT_EQ(rules.size(), 3U);
  EXPECT_EQ(rules[0].refs, (std::vector<std::int32_t>{1, 2}));
  EXPECT_EQ(rules[0].h_min, 0.1);
  EXPECT_EQ(rules[0].h_max, 0.1);
  EXPECT_EQ(rules[1].change, LocalRule::Change::kNone);
  EXPECT_EQ(rules[1].h_min, 0);
  EXPECT_EQ(rules[2].on, LocalRule::On::kRegions);
  EXPECT_EQ(rules[2].h_max, 2);
}

TEST(LocalFile, MistakesAreToldWithTheirLine) {
  const auto refused = [](const std::string& text, std::initializer_list<std::string> words) {
    expect_error([&] { parse_local(text, "a.toml"); }, ExitCode::kInput, words);
  };
  refused("[[patch]]\nref = 1\nsize = -1\n", {"a.toml:3", "size"});
  refused("[[patch]]\nref = 1\nsise = 1\n", {"a.toml:3", "sise", "size"});
  refused("[[patch]]\nref = 1\n", {"a.toml:1", "says nothing"});
  refused("[[patch]]\nsize = 1\n", {"a.toml:1", "ref", "name"});
  refused("[[patch]]\nname = \"wing\"\nsize = 1\n", {"a.toml:2", "wing", "[names]"});
  refused("[[patch]]\nref = 1.5\nsize = 1\n", {"a.toml:2", "whole number"});
  refused("[[patch]]\nref = 1\nhmin = 2\nhmax = 1\n", {"a.toml:1", "greater"});
  refused("[patch]\nref = 1\n", {"[[patch]]"});
  refused("[[volume]]\nref = 1\n", {"volume", "[[region]]"});
  refused("[[patch]\n", {"a.toml:1"});
}

/// The unit cube of two regions, with patches 1 to 6 on its sides.
DistMesh cube_in_parts() {
  return distribute(world(), test::slices(world(), test::cube(4, test::Regions::kTwoTagged)));
}

// Vertices at the border of parts know the patches of all their triangles, wherever these are.
TEST(LocalBounds, HoldOnPatchesAndInRegionsAndNowhereElse) {
  DistMesh dist = cube_in_parts();
  const std::int32_t patch = dist.mesh.patch_ref.front(), region = world().max(dist.mesh.tet_ref.empty() ? 0 : 2);
  std::vector<LocalRule> rules(2);
  rules[0].refs = {patch}, rules[0].h_min = rules[0].h_max = 0.05;
  rules[1].on = LocalRule::On::kRegions, rules[1].refs = {region}, rules[1].h_max = 0.2;
  std::vector<double> in_patch(dist.mesh.vert_slots(), 0), in_region = in_patch;
  for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (dist.mesh.tet_ref[t] == region) in_region[idx(dist.mesh.tet2vert[t][k])] = 1;
      const FaceTag tag = dist.mesh.face_tag[t][k];
      if (tag == 0 || dist.mesh.patch_ref[static_cast<std::size_t>(tag_patch(tag))] != patch) continue;
      for (const VertId v : dist.mesh.verts(make_face(t, k))) in_patch[idx(v)] = 1;
    }
  }
  const Halo halo(world(), dist.sharing);
  halo.max<double>(in_patch);
  halo.max<double>(in_region);
  std::vector<SymTensor> log_m(dist.mesh.vert_slots(), log(SymTensor{1, 0, 4, 0, 0, 9}));
  const auto before = log_m;
  LocalBounds(world(), dist, rules).apply(log_m);
  for (std::size_t v = 0; v < log_m.size(); ++v) {
    const Eigen e = eigen(log_m[v]);
    const double smallest = std::exp(-0.5 * e.value[2]), largest = std::exp(-0.5 * e.value[0]);
    if (in_patch[v] != 0) {
      EXPECT_NEAR(smallest, 0.05, 1e-12);
      EXPECT_NEAR(largest, 0.05, 1e-12);
    } else if (in_region[v] != 0) {
      EXPECT_LE(largest, 0.2 * (1 + 1e-12));
    } else {
      EXPECT_EQ(log_m[v], before[v]);
    }
  }
}

TEST(LocalRules, FreezeEntitiesAndRefuseUnknownReferences) {
  MeshSlice mesh = test::slices(world(), test::cube(4, test::Regions::kTwoTagged));
  const std::int32_t patch = world().broadcast(mesh.triangles.ref.empty() ? 0 : mesh.triangles.ref.front());
  std::vector<LocalRule> rules(1);
  rules[0].refs = {patch}, rules[0].change = LocalRule::Change::kNone;
  const std::int64_t before = mesh.required_triangles.total;
  apply_to_entities(world(), rules, mesh);
  const auto mine = std::count(mesh.triangles.ref.begin(), mesh.triangles.ref.end(), patch);
  EXPECT_EQ(mesh.required_triangles.total, before + world().sum(static_cast<std::int64_t>(mine)));
  EXPECT_EQ(mesh.required_tets.total, 0);
  rules[0].refs = {12345}, rules[0].where = "x.toml:7";
  try {
    apply_to_entities(world(), rules, mesh);
    FAIL() << "not refused";
  } catch (const AgreedError& e) {
    EXPECT_NE(std::string(e.what()).find("x.toml:7"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("no patch 12345"), std::string::npos) << e.what();
  }
}

TEST(Strictest, IsWithinBothAndNoStricterThanNeeded) {
  const SymTensor a = log(compose({{1, 4, 100}, {Vec3{0.6, 0.8, 0}, Vec3{-0.8, 0.6, 0}, Vec3{0, 0, 1}}}));
  const SymTensor b = log(SymTensor{9, 0, 1, 0, 0, 2});
  const SymTensor m = exp(strictest(a, b));
  for (const Vec3 d : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 1}, Vec3{1, -2, 0.5}}) {
    const double both = std::max(quad(exp(a), d), quad(exp(b), d));
    EXPECT_GE(quad(m, d), both * (1 - 1e-9));
  }
  EXPECT_NEAR(det(exp(strictest(a, a))), det(exp(a)), 1e-9 * det(exp(a)));
  const SymTensor none = isotropic(-460), open{-700, 0, 2, 0, 0, 2};  // no limit at all, and none in one direction
  EXPECT_EQ(strictest(a, none), a);
  EXPECT_TRUE(is_finite(strictest(open, a)));
}

TEST(OwnMetric, KeepsTheNumberOfTetrahedraAndTheStretch) {
  DistMesh dist = test::DealtCube{8, 0.1}.part(world());
  for (Vec3& x : dist.mesh.coords) x.z *= 0.1;
  const auto own = own_log_metric(world(), dist);
  EXPECT_NEAR(complexity_from_log(world(), dist, own) * kResultTetsPerComplexity, double(dist.global_tets),
              1e-6 * double(dist.global_tets));
  for (const SymTensor& l : own) EXPECT_GT(l.zz - l.xx, 2 * std::log(5)) << "ten times as fine across as along";
}

TEST(Policy, SourcesAspectAndLocalRulesHoldAndTheComplexityIsMet) {
  DistMesh dist = test::DealtCube{8, 0.1}.part(world());
  MetricPolicy policy;
  policy.complexity = 2e4;
  policy.aspect_max = 4;
  policy.sources.sources.push_back({1, {Vec3{0.5, 0.5, 0.5}}, 0.02, 0.2, 0.4});
  dist.mesh.log_metric.assign(dist.mesh.vert_slots(), log(SymTensor{1, 0, 400, 0, 0, 1}));
  const MetricReport report = make_metric(world(), dist, policy);
  EXPECT_NEAR(std::log(report.complexity / 2e4), 0, 2e-3);
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const Eigen e = eigen(dist.mesh.log_metric[v]);
    EXPECT_LE(e.value[2] - e.value[0], 2 * std::log(4) + 1e-9);
    EXPECT_LE(std::exp(-0.5 * e.value[0]), policy.sources.at(dist.mesh.coords[v]) * (1 + 1e-9));
  }
}

TEST(Policy, SeveralFieldsGiveTheStrictestOfTheirMetrics) {
  const auto of = [&](auto f) {
    DistMesh dist = test::DealtCube{8, 0}.part(world());
    dist.mesh.fields = f(dist);
    MetricPolicy policy{.source = MetricSource::kField, .complexity = 2000};
    const MetricReport report = make_metric(world(), dist, policy);
    EXPECT_NEAR(std::log(report.complexity / 2000), 0, 2e-3);
    return dist.mesh.log_metric.raw();
  };
  const auto wave = [](double x) { return std::tanh(8 * (x - 0.5)); };
  const auto twice = of([&](const DistMesh& d) {
    VertFields f{2, {}};
    for (const Vec3 x : d.mesh.coords) f.values.insert(f.values.end(), {wave(x.x), wave(x.z)});
    return f;
  });
  DistMesh dist = test::DealtCube{8, 0}.part(world());
  double fine_x = 0, fine_z = 0;
  for (std::size_t v = 0; v < twice.size(); ++v) {
    const Vec3 x = dist.mesh.coords[to_id<VertId>(v)];
    if (std::abs(x.x - 0.5) < 0.2 && std::abs(x.z - 0.5) > 0.3) fine_x = std::max(fine_x, twice[v].xx - twice[v].zz);
    if (std::abs(x.z - 0.5) < 0.2 && std::abs(x.x - 0.5) > 0.3) fine_z = std::max(fine_z, twice[v].zz - twice[v].xx);
  }
  EXPECT_GT(world().max(fine_x), 1);
  EXPECT_GT(world().max(fine_z), 1);
}

}  // namespace
}  // namespace skein
