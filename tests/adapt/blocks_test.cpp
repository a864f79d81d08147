// Blocks of threads: cutting and joining gives the mesh that was.
#include "adapt/blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <set>

#include "adapt/gaps.hpp"
#include "dist/partition.hpp"
#include "kernel/recipe.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "tests/kernel/metrics.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::test {
namespace {

using Items = std::multiset<std::vector<double>>;

void put(std::vector<double>& item, const TetMesh& m, VertId v) {
  const Vec3 x = m.coords[v];
  const SymTensor& l = m.log_metric[v];
  item.insert(item.end(), {x.x, x.y, x.z, l.xx, l.xy, l.yy, l.xz, l.yz, l.zz, double(m.vert_class[v]),
                           double(m.vert_state[v]), double(m.vert_ref[v])});
}
/// The whole mesh by coordinates: tetrahedra with all that is at them, feature edges.
Items content(const TetMesh& m) {
  Items out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    std::vector<double> item{double(m.tet_ref[t])};
    for (std::size_t i = 0; i < 4; ++i) {
      put(item, m, m.tet2vert[t][i]);
      item.push_back(m.face_tag[t][i]);
    }
    out.insert(item);
  }
  for (const auto& e : m.features.list()) {
    std::vector<double> a, b;
    put(a, m, e.a);
    put(b, m, e.b);
    if (b < a) std::swap(a, b);
    a.insert(a.end(), b.begin(), b.end());
    a.insert(a.end(), {double(e.ref), double(e.edge_class)});
    out.insert(a);
  }
  return out;
}

struct Whole {
  TetMesh mesh;
};
Whole whole(unsigned seed, bool regions = true) {
  std::mt19937 random(seed);
  Whole w;
  w.mesh = make_mesh({.n = 6, .two_regions = regions, .required = true, .perturb = 0.2, .seed = seed});
  compact(w.mesh);
  // As between ranks: some vertices are frozen already.
  for (const VertId v : IdRange<VertId>(w.mesh.vert_slots())) {
    if (w.mesh.coords[v].y == 0) w.mesh.vert_state[v] |= kFrozen;
  }
  set_metric(w.mesh, random_smooth_metric(random, 0.1, 0.3, 1));
  return w;
}

std::vector<Block> cut(const Whole& w, const BlockLabels& label, int blocks) {
  const auto between = between_blocks(w.mesh, label);
  std::vector<Block> out;
  for (int b = 0; b < blocks; ++b) out.push_back(cut_block(w.mesh, label, between, b));
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

/// Leaves n free slots among the tetrahedra and the vertices, as passes do: every other one of the first is at the end
/// now. Returns old vertex -> new vertex.
IdVector<VertId, VertId> make_gaps(Part& p, std::size_t n) {
  TetMesh& m = p.mesh;
  IdVector<VertId, VertId> old2new(m.vert_slots());
  for (const VertId v : IdRange<VertId>(old2new.size())) old2new[v] = v;
  const std::size_t nv = std::min(n, m.vert_slots() / 2), nt = std::min(n, m.tet_slots() / 2);
  for (std::size_t i = 0; i < nv; ++i) {
    const auto v = to_id<VertId>(2 * i);
    append_entries(m);
    old2new[v] = m.vert2tet.push_back(m.vert2tet[v]);
    move_entries(m, v, old2new[v]);
    m.vert2tet[v] = kNoTet;
    p.free_verts.insert(p.free_verts.begin(), v);
  }
  for (auto& tv : m.tet2vert) {
    for (VertId& v : tv) v = old2new[v];
  }
  FeatureEdges features;
  for (const auto& e : m.features.list()) features.insert({old2new[e.a], old2new[e.b], e.ref, e.edge_class});
  m.features = std::move(features);
  for (std::size_t i = 0; i < nt; ++i) {
    const auto t = to_id<TetId>(2 * i);
    const TetId to = m.tet2vert.push_back(m.tet2vert[t]);
    m.tet2face.push_back(m.tet2face[t]);
    m.face_tag.push_back(m.face_tag[t]);
    m.tet_ref.push_back(m.tet_ref[t]);
    m.tet_class.push_back(m.tet_class[t]);
    for (const VertId v : m.tet2vert[to]) m.vert2tet[v] = to;
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceId other = m.tet2face[to][f];
      if (other != kNoFace) m.link(other, make_face(to, f));
    }
    m.tet2vert[t].fill(kNoVert);
    m.tet2face[t].fill(kNoFace);
    p.free_tets.insert(p.free_tets.begin(), t);
  }
  return old2new;
}

/// Gaps are filled from the end where they are few, else all moves up: the mesh is the same, and numbers follow.
TEST(Gaps, AreClosedWithoutAChange) {
  std::array<int, 2> seen{};  // few, many
  for (const double h : {0.05, 0.12, 0.3, 0.6}) {
    Part p;
    p.mesh = make_mesh({.n = 6, .two_regions = true, .required = true, .perturb = 0.2});
    set_metric(p.mesh, UniformMetric{h});
    prepare(p);
    adapt_part(p);
    const auto before = content(p.mesh);
    const auto coords = p.mesh.coords;
    std::size_t free = 0, live_verts = 0;
    for (const TetId t : IdRange<TetId>(p.mesh.tet_slots())) free += p.mesh.is_live(t) ? 0 : 1;
    ++seen[8 * free > p.mesh.tet_slots() ? 1 : 0];
    std::vector<char> live(coords.size());
    for (const VertId v : IdRange<VertId>(coords.size())) live_verts += live[idx(v)] = p.mesh.is_live(v) ? 1 : 0;

    const auto old2new = close_gaps(p.mesh);
    ASSERT_EQ(check(p.mesh), "");
    EXPECT_EQ(content(p.mesh), before);
    EXPECT_EQ(p.mesh.vert_slots(), live_verts);
    EXPECT_EQ(p.mesh.metric.size(), live_verts);
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
    BlockLabels label = cut_blocks(w.mesh, blocks);
    std::mt19937 random(seed);
    if (seed == 3) {  // any cut will do
      for (auto& l : label) l = static_cast<std::int32_t>(random() % static_cast<unsigned>(blocks));
    }
    auto parts = cut(w, label, blocks);
    for (const Block& b : parts) ASSERT_EQ(check(b.part.mesh), "");
    seal(parts);
    const Merged merged = merge_blocks(parts, w.mesh.vert_slots());
    ASSERT_EQ(check(merged.mesh), "");
    EXPECT_EQ(content(merged.mesh), content(w.mesh));
    EXPECT_EQ(merged.mesh.vert_slots(), w.mesh.vert_slots());
    EXPECT_EQ(merged.mesh.patch_ref, w.mesh.patch_ref);
    EXPECT_TRUE(interface_faces(merged.mesh).empty());
    for (const VertId v : IdRange<VertId>(w.mesh.vert_slots())) {
      ASSERT_EQ(merged.old2new[v] != kNoVert, w.mesh.has(v, kFrozen));
      EXPECT_TRUE(merged.old2new[v] == kNoVert || merged.mesh.coords[merged.old2new[v]] == w.mesh.coords[v]);
    }
  }
}

/// Free slots of the first block are filled with what is in the others, and those of the others do not come along; few
/// or many of them, in blocks of like sizes or in a large one beside small ones, which have not enough to fill it.
TEST_P(Blocks, GapsAreFilledWhenBlocksAreMerged) {
  const int blocks = GetParam();
  const Whole w = whole(1);
  std::array<int, 2> seen{};
  for (const bool small : {false, true}) {
    for (const std::size_t gaps : {0, 1, 12, 60, 300}) {
      TetMesh copy = w.mesh;
      BlockLabels label = cut_blocks(copy, blocks);
      if (small) {
        for (const TetId t : IdRange<TetId>(label.size())) label[t] = idx(t) < 4 ? 1 : 0;
      }
      auto parts = cut(w, label, blocks);
      for (std::size_t b = 0; b < parts.size(); ++b) {
        Part& p = parts[b].part;
        seal_block(parts[b], make_gaps(p, (b + 1) * gaps));
        ASSERT_EQ(check(p.mesh), "");
        if (b == 0) ++seen[p.free_tets.size() > 4 ? 1 : 0];
      }
      const Merged merged = merge_blocks(parts, w.mesh.vert_slots());
      ASSERT_EQ(check(merged.mesh), "");
      EXPECT_EQ(content(merged.mesh), content(w.mesh));
      EXPECT_EQ(merged.mesh.vert_slots(), w.mesh.vert_slots());
      EXPECT_EQ(merged.mesh.tet_slots(), w.mesh.tet_slots());
      EXPECT_EQ(merged.mesh.metric.size(), w.mesh.vert_slots());
      const auto between = between_blocks(w.mesh, label);
      EXPECT_EQ(merged.between.size(), static_cast<std::size_t>(std::count(between.begin(), between.end(), 1)));
      EXPECT_TRUE(std::is_sorted(merged.between.begin(), merged.between.end()));
      for (const VertId v : IdRange<VertId>(w.mesh.vert_slots())) {
        ASSERT_EQ(merged.old2new[v] != kNoVert, w.mesh.has(v, kFrozen));
        EXPECT_TRUE(merged.old2new[v] == kNoVert || merged.mesh.coords[merged.old2new[v]] == w.mesh.coords[v]);
      }
    }
  }
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[1], 0);
}

TEST_P(Blocks, WithRefinedInterfacesTheyFitTogether) {
  const int blocks = GetParam();
  for (unsigned seed = 0; seed < 4; ++seed) {
    Whole w = whole(seed);
    const Measures before = measure(w.mesh);
    auto parts = cut(w, cut_blocks(w.mesh, blocks), blocks);
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

/// Between the two steps in which points are created, the blocks change on their own, and their interfaces still fit.
TEST_P(Blocks, WithInterfacesRefinedInTwoStepsTheyFitTogether) {
  constexpr double kSize = 0.03;
  const int blocks = GetParam();
  Whole w;
  w.mesh = make_mesh({.n = 6, .two_regions = true, .required = true});  // plane patches keep their areas
  compact(w.mesh);
  set_metric(w.mesh, UniformMetric{kSize});
  const Measures before = measure(w.mesh);
  auto parts = cut(w, cut_blocks(w.mesh, blocks), blocks);
  const auto longest = [](const Block& b) {
    double l = 0;
    for (const auto& v : interface_faces(b.part.mesh)) {
      for (std::size_t i = 0; i < 3; ++i) l = std::max(l, b.part.length(v[i], v[(i + 1) % 3]));
    }
    return l;
  };
  for (Block& b : parts) {
    prepare(b.part);
    const double above = b.part.options.method.lengths.split_above;
    ASSERT_TRUE(refine_block_interface(b, Method{}.lengths.first_step));
    EXPECT_LE(longest(b), Method{}.lengths.first_step * above);
    EXPECT_GT(longest(b), above);  // else the second step has nothing to do
    const std::size_t coarse = b.common.size();
    const std::int64_t inserted = b.part.counts.insert;
    follow(b, create_coarse_points(b.part));
    EXPECT_GT(b.part.counts.insert, inserted);
    ASSERT_TRUE(refine_block_interface(b));
    EXPECT_LE(longest(b), above);
    EXPECT_GT(b.common.size(), coarse);
    ASSERT_EQ(check(b.part.mesh), "");
    const std::set<GlobalId> ids = [&] {
      std::set<GlobalId> out;
      for (const VertId v : b.common) out.insert(b.id[v]);
      return out;
    }();
    EXPECT_EQ(ids.size(), b.common.size());
    EXPECT_FALSE(ids.contains(kNoGlobal));
  }
  seal(parts);
  const Merged merged = merge_blocks(parts, w.mesh.vert_slots());
  ASSERT_EQ(check(merged.mesh), "");
  EXPECT_TRUE(interface_faces(merged.mesh).empty());
  EXPECT_EQ(differ(before, measure(merged.mesh), 1e-12), "");
}

TEST_P(Blocks, AreCutFromARanksMesh) {
  Whole w = whole(0);
  for (const TetId t : IdRange<TetId>(w.mesh.tet_slots())) {  // its side of y = 0 lies between ranks
    for (std::size_t f = 0; f < 4; ++f) {
      const auto v = w.mesh.verts(make_face(t, f));
      const bool between = std::all_of(v.begin(), v.end(), [&](VertId i) { return w.mesh.has(i, kFrozen); });
      if (between) w.mesh.face_tag[t][f] = 0;
    }
  }
  const auto open = interface_faces(w.mesh);
  ASSERT_FALSE(open.empty());
  const Items before = content(w.mesh);
  const auto label = cut_blocks(w.mesh, GetParam());
  EXPECT_EQ(label.size(), w.mesh.tet_slots());
  EXPECT_EQ(content(w.mesh), before);
  EXPECT_EQ(interface_faces(w.mesh), open);
}

TEST_P(Blocks, HaveEqualWork) {
  const int blocks = GetParam();
  Whole w = whole(1, false);
  const auto label = cut_blocks(w.mesh, blocks);
  const auto work = predicted_work(w.mesh);
  std::vector<double> of_block(static_cast<std::size_t>(blocks), 0);
  for (const TetId t : IdRange<TetId>(w.mesh.tet_slots())) of_block[label[t]] += work[idx(t)];
  const double mean = std::accumulate(work.begin(), work.end(), 0.0) / blocks;
  const double heaviest = *std::max_element(work.begin(), work.end());
  for (const double one : of_block) EXPECT_LE(one, 1.03 * mean + heaviest);
}

INSTANTIATE_TEST_SUITE_P(Counts, Blocks, ::testing::Values(2, 3, 4, 7));

}  // namespace
}  // namespace skein::test
