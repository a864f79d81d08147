// Blocks of threads: cutting and joining gives the mesh that was.
#include "adapt/blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <set>

#include "adapt/gaps.hpp"
#include "kernel/passes.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "partition/partition.hpp"
#include "tests/kernel/metrics.hpp"
#include "tests/mesh/meshes.hpp"

namespace skein::test {
namespace {

using Items = std::multiset<std::vector<double>>;

void put(std::vector<double>& item, const TetMesh& m, const MetricField& f, VertId v) {
  const Vec3 x = m.coords[v];
  const SymTensor& l = f.log_at[v];
  item.insert(item.end(),
              {x.x, x.y, x.z, l.xx, l.xy, l.yy, l.xz, l.yz, l.zz, double(m.vert_flags[v]), double(m.vert_ref[v])});
}
/// The whole mesh by coordinates: tetrahedra with all that is at them, feature edges.
Items content(const TetMesh& m, const MetricField& f) {
  Items out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    std::vector<double> item{double(m.tet_ref[t])};
    for (std::size_t i = 0; i < 4; ++i) {
      put(item, m, f, m.tet2vert[t][i]);
      item.push_back(m.face_tag[t][i]);
    }
    out.insert(item);
  }
  for (const auto& e : m.features.list()) {
    std::vector<double> a, b;
    put(a, m, f, e.a);
    put(b, m, f, e.b);
    if (b < a) std::swap(a, b);
    a.insert(a.end(), b.begin(), b.end());
    a.insert(a.end(), {double(e.ref), double(e.ridge)});
    out.insert(a);
  }
  return out;
}

struct Whole {
  TetMesh mesh;
  MetricField metric;
};
Whole whole(unsigned seed, bool regions = true) {
  std::mt19937 random(seed);
  Whole w;
  w.mesh = make_mesh({.n = 6, .two_regions = regions, .required = true, .perturb = 0.2, .seed = seed});
  compact(w.mesh);
  // As between ranks: some vertices are frozen already.
  for (const VertId v : IdRange<VertId>(w.mesh.vert_slots())) {
    if (w.mesh.coords[v].y == 0) w.mesh.vert_flags[v] |= kFrozen;
  }
  w.metric = metric_field(w.mesh.coords, random_smooth_metric(random, 0.1, 0.3, 1));
  return w;
}

std::vector<Block> cut(const Whole& w, const BlockLabels& label, int blocks) {
  const auto between = between_blocks(w.mesh, label);
  std::vector<Block> out;
  for (int b = 0; b < blocks; ++b) out.push_back(cut_block(w.mesh, w.metric, label, between, b));
  return out;
}

/// What adapt_part would be followed by, had it changed nothing.
void seal(std::vector<Block>& blocks) {
  for (Block& b : blocks) {
    IdVector<VertId, VertId> same(b.part.mesh.vert_slots());
    for (const VertId v : IdRange<VertId>(same.size())) same[v] = v;
    seal_block(b, same);
  }
}

/// Gaps are filled from the end where they are few, else all moves up: the mesh is the same, and numbers follow.
TEST(Gaps, AreClosedWithoutAChange) {
  std::array<int, 2> seen{};  // few, many
  for (const double h : {0.05, 0.12, 0.3, 0.6}) {
    Part p;
    p.mesh = make_mesh({.n = 6, .two_regions = true, .required = true, .perturb = 0.2});
    for (std::size_t v = 0; v < p.mesh.vert_slots(); ++v) p.metric.push_back_log(log(isotropic(1 / (h * h))));
    prepare(p);
    adapt_part(p);
    const auto before = content(p.mesh, p.metric);
    const auto coords = p.mesh.coords;
    std::size_t free = 0, live_verts = 0;
    for (const TetId t : IdRange<TetId>(p.mesh.tet_slots())) free += p.mesh.is_live(t) ? 0 : 1;
    ++seen[8 * free > p.mesh.tet_slots() ? 1 : 0];
    std::vector<char> live(coords.size());
    for (const VertId v : IdRange<VertId>(coords.size())) live_verts += live[idx(v)] = p.mesh.is_live(v) ? 1 : 0;

    const auto old2new = close_gaps(p.mesh, p.metric);
    ASSERT_EQ(check(p.mesh), "");
    EXPECT_EQ(content(p.mesh, p.metric), before);
    EXPECT_EQ(p.mesh.vert_slots(), live_verts);
    EXPECT_EQ(p.metric.size(), live_verts);
    for (const TetId t : IdRange<TetId>(p.mesh.tet_slots())) EXPECT_TRUE(p.mesh.is_live(t));
    for (const VertId v : IdRange<VertId>(coords.size())) {
      ASSERT_EQ(old2new[v] != kNoVert, live[idx(v)] != 0);
      if (old2new[v] == kNoVert) continue;
      EXPECT_EQ(norm(p.mesh.coords[old2new[v]] - coords[v]), 0);
    }
  }
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[1], 0);
}

class Blocks : public ::testing::TestWithParam<int> {};

TEST_P(Blocks, CutAndMergedAreTheMeshAgain) {
  const int blocks = GetParam();
  for (unsigned seed = 0; seed < 4; ++seed) {
    Whole w = whole(seed);
    BlockLabels label = cut_blocks(w.mesh, w.metric, blocks);
    std::mt19937 random(seed);
    if (seed == 3) {  // any cut will do
      for (auto& l : label) l = static_cast<std::int32_t>(random() % static_cast<unsigned>(blocks));
    }
    auto parts = cut(w, label, blocks);
    for (const Block& b : parts) ASSERT_EQ(check(b.part.mesh), "");
    seal(parts);
    const Merged merged = merge_blocks(parts, w.mesh.vert_slots());
    ASSERT_EQ(check(merged.mesh), "");
    EXPECT_EQ(content(merged.mesh, merged.metric), content(w.mesh, w.metric));
    EXPECT_EQ(merged.mesh.vert_slots(), w.mesh.vert_slots());
    EXPECT_EQ(merged.mesh.patch_ref, w.mesh.patch_ref);
    EXPECT_TRUE(interface_faces(merged.mesh).empty());
    for (const VertId v : IdRange<VertId>(w.mesh.vert_slots())) {
      ASSERT_EQ(merged.old2new[v] != kNoVert, w.mesh.has(v, kFrozen));
      EXPECT_TRUE(merged.old2new[v] == kNoVert || merged.mesh.coords[merged.old2new[v]] == w.mesh.coords[v]);
    }
  }
}

TEST_P(Blocks, WithRefinedInterfacesTheyFitTogether) {
  const int blocks = GetParam();
  for (unsigned seed = 0; seed < 4; ++seed) {
    Whole w = whole(seed);
    const Measures before = measure(w.mesh);
    auto parts = cut(w, cut_blocks(w.mesh, w.metric, blocks), blocks);
    for (Block& b : parts) {
      prepare(b.part);
      ASSERT_TRUE(refine_block_interface(b));
    }
    seal(parts);
    const Merged merged = merge_blocks(parts, w.mesh.vert_slots());
    ASSERT_EQ(check(merged.mesh), "");
    EXPECT_TRUE(interface_faces(merged.mesh).empty());
    EXPECT_EQ(differ(before, measure(merged.mesh), 1e-12), "");
  }
}

TEST_P(Blocks, AreCutFromARanksMesh) {
  Whole w = whole(0);
  for (const TetId t : IdRange<TetId>(w.mesh.tet_slots())) {  // its side of y = 0 lies between ranks
    for (int f = 0; f < 4; ++f) {
      const auto v = face_verts(w.mesh, make_face(t, f));
      const bool between = std::all_of(v.begin(), v.end(), [&](VertId i) { return w.mesh.has(i, kFrozen); });
      if (between) w.mesh.face_tag[t][static_cast<std::size_t>(f)] = 0;
    }
  }
  const auto open = interface_faces(w.mesh);
  ASSERT_FALSE(open.empty());
  const Items before = content(w.mesh, w.metric);
  const auto label = cut_blocks(w.mesh, w.metric, GetParam());
  EXPECT_EQ(label.size(), w.mesh.tet_slots());
  EXPECT_EQ(content(w.mesh, w.metric), before);
  EXPECT_EQ(interface_faces(w.mesh), open);
}

TEST_P(Blocks, HaveEqualWork) {
  const int blocks = GetParam();
  Whole w = whole(1, false);
  const auto label = cut_blocks(w.mesh, w.metric, blocks);
  DistMesh dist;
  dist.mesh = w.mesh;
  dist.data.width = 6;
  for (const SymTensor& l : w.metric.log_at) {
    dist.data.values.insert(dist.data.values.end(), {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz});
  }
  const auto work = predicted_work(dist);
  std::vector<double> of_block(static_cast<std::size_t>(blocks), 0);
  for (const TetId t : IdRange<TetId>(w.mesh.tet_slots())) of_block[static_cast<std::size_t>(label[t])] += work[idx(t)];
  const double mean = std::accumulate(work.begin(), work.end(), 0.0) / blocks;
  const double heaviest = *std::max_element(work.begin(), work.end());
  for (const double one : of_block) EXPECT_LE(one, 1.03 * mean + heaviest);
}

INSTANTIATE_TEST_SUITE_P(Counts, Blocks, ::testing::Values(2, 3, 4, 7));

}  // namespace
}  // namespace skein::test
