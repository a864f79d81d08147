// Vertex columns: whatever a mesh keeps for its vertices goes wherever they go. All is done for every column of the
// list, so a new column is tested as soon as it is there.
#include <gtest/gtest.h>

#include <cstring>

#include "adapt/band.hpp"
#include "adapt/blocks.hpp"
#include "adapt/gaps.hpp"
#include "adapt/local.hpp"
#include "base/hash.hpp"
#include "dist/migrate.hpp"
#include "dist/sharing.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "mesh/vert_columns.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/tet_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

// Flags of two kinds are no set.
template <class A, class B>
concept Joins = requires(A a, B b) {
  a | b;
};
static_assert(Joins<VertClass, VertClass> && Joins<VertState, VertState> && !Joins<VertClass, VertState>);
static_assert(!std::is_convertible_v<VertClass, int> && !std::is_convertible_v<VertState, int>);

/// What makes a vertex itself, as nothing here moves one.
std::uint64_t key_of(Vec3 x) {
  const auto bits = [](double d) { return std::bit_cast<std::uint64_t>(d); };
  return mix(mix(mix(bits(x.x)) ^ bits(x.y)) ^ bits(x.z));
}

/// A value that no other vertex and no other column has: numbers between -1 and 1 where it may be numbers.
template <class T>
T distinct(std::uint64_t key) {
  T out{};
  auto* bytes = reinterpret_cast<unsigned char*>(&out);
  if constexpr (sizeof(T) % sizeof(double) == 0) {
    for (std::size_t i = 0; i < sizeof(T); i += sizeof(double)) {
      key = mix(key + 1);
      const double number = 2.0 * static_cast<double>(key >> 11) / static_cast<double>(std::uint64_t{1} << 53) - 1;
      std::memcpy(bytes + i, &number, sizeof number);
    }
  } else {
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = static_cast<unsigned char>(mix(key + i));
  }
  return out;
}

/// Gives f(number of the column, column) for all that may have any values; the others have a meaning to the operators.
template <class Mesh, class F>
void for_each_free_column(Mesh& m, F&& f) {
  std::uint64_t number = 0;
  for_each_vert_column(m, [&](auto& c) {
    using Entry = EntryOf<decltype(c)>;
    ++number;
    if constexpr (!FlagSet<Entry> && !std::is_same_v<Entry, Vec3> && !std::is_same_v<Entry, VertMetric>) f(number, c);
  });
}

void mark_column(const TetMesh& m, std::uint64_t number, auto& c) {
  resize_column(c, m.vert_slots());
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    for (std::size_t k = 0; k < width_of(c); ++k)
      c.raw()[idx(v) * width_of(c) + k] = distinct<EntryOf<decltype(c)>>(key_of(m.coords[v]) + 100 * number + k);
  }
}

/// Fills every column.
void mark(TetMesh& m) {
  m.fields.width = 3;
  for_each_free_column(m, [&](std::uint64_t number, auto& c) { mark_column(m, number, c); });
  measure_metric(m);
}

/// Every column is there and has at every vertex what mark() has put there.
void expect_marked(TetMesh& m) {
  for_each_vert_column(m, [&](const auto& c) { EXPECT_EQ(c.size(), m.vert_slots()); });
  for_each_free_column(m, [&](std::uint64_t number, const auto& c) {
    auto expected = c;
    mark_column(m, number, expected);
    ASSERT_EQ(c.raw().size(), expected.raw().size()) << "column " << number;
    if (c.empty()) return;
    EXPECT_EQ(std::memcmp(c.raw().data(), expected.raw().data(), c.raw().size() * sizeof(c.raw()[0])), 0)
        << "column " << number;
  });
  for (const VertId v : IdRange<VertId>(m.metric.size())) {
    EXPECT_NEAR(m.metric[v].sqrt_det, vert_metric_from_log(m.log_metric[v]).sqrt_det, 1e-12);
  }
}

TetMesh marked_mesh(int n) {
  TetMesh m = make_mesh({.n = n, .two_regions = true, .perturb = 0.2});
  for (VertState& s : m.vert_state) s = {};
  compact(m);
  mark(m);
  return m;
}

/// Moves the first n vertices to the end; their slots become free.
void make_gaps(TetMesh& m, std::size_t n) {
  IdVector<VertId, VertId> old2new(m.vert_slots());
  for (const VertId v : IdRange<VertId>(old2new.size())) old2new[v] = v;
  for (const VertId v : IdRange<VertId>(n)) {
    append_entries(m);
    old2new[v] = m.vert2tet.push_back(m.vert2tet[v]);
    move_entries(m, v, old2new[v]);
    clear_entries(m, v);
    m.vert2tet[v] = kNoTet;
  }
  for (auto& tv : m.tet2vert) {
    for (VertId& v : tv) v = old2new[v];
  }
  FeatureEdges features;
  for (const auto& e : m.features.list()) features.insert({old2new[e.a], old2new[e.b], e.ref, e.edge_class});
  m.features = std::move(features);
}

TEST(VertColumns, FollowWhenSlotsAreTakenOut) {
  for (const auto& take_out :
       {+[](TetMesh& m) { compact(m); }, +[](TetMesh& m) { squeeze(m); }, +[](TetMesh& m) { close_gaps(m); }}) {
    TetMesh m = marked_mesh(4);
    const std::size_t verts = m.vert_slots();
    make_gaps(m, 20);
    take_out(m);
    EXPECT_EQ(m.vert_slots(), verts);
    EXPECT_EQ(check(m), "");
    expect_marked(m);
  }
}

TEST(VertColumns, FollowThroughBlocks) {
  for (const int blocks : {2, 3}) {
    const TetMesh m = marked_mesh(6);
    const auto label = cut_blocks(m, blocks);
    const auto between = between_blocks(m, label);
    std::vector<Block> parts;
    for (int b = 0; b < blocks; ++b) parts.push_back(cut_block(m, label, between, b));
    for (Block& b : parts) {
      expect_marked(b.part.mesh);
      IdVector<VertId, VertId> same(b.part.mesh.vert_slots());
      for (const VertId v : IdRange<VertId>(same.size())) same[v] = v;
      seal_block(b, same);
    }
    Merged merged = merge_blocks(parts, m.vert_slots());
    EXPECT_EQ(merged.mesh.vert_slots(), m.vert_slots());
    expect_marked(merged.mesh);
  }
}

IdVector<VertId, VertId> frozen_stay(const TetMesh& m) {
  IdVector<VertId, VertId> old2new(m.vert_slots(), kNoVert);
  for (const VertId v : IdRange<VertId>(old2new.size())) old2new[v] = m.has(v, kFrozen) ? v : kNoVert;
  return old2new;
}

TEST(VertColumns, FollowThroughBands) {
  TetMesh m = marked_mesh(6);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (m.coords[v].x < 0.4) m.vert_state[v] |= kActive;
  }
  Band band = cut_band(m, 1, 2);
  EXPECT_LT(band.mesh.vert_slots(), m.vert_slots());
  expect_marked(band.mesh);
  put_back(m, band, frozen_stay(band.mesh), {}, 2);
  EXPECT_EQ(check(m), "");
  expect_marked(m);
}

TEST(VertColumns, FollowThroughAnAdaptationThatChangesNothing) {
  for (const int threads : {1, 3}) {
    TetMesh m = marked_mesh(10);
    const std::size_t verts = m.vert_slots();
    LocalOptions options;
    options.threads = threads;
    const LocalResult r = adapt_local(m, options);
    EXPECT_EQ(r.counts.insert + r.counts.collapse + r.counts.swap + r.counts.smooth, 0);
    EXPECT_EQ(m.vert_slots(), verts);
    EXPECT_TRUE(m.anchor.empty());  // the kernel's own while it works
    for_each_free_column(m, [&](std::uint64_t number, auto& c) {
      if constexpr (std::is_same_v<EntryOf<decltype(c)>, Anchor>) mark_column(m, number, c);
    });
    expect_marked(m);
  }
}

TEST(VertColumns, FollowFromRankToRank) {
  const Comm& comm = world();
  DistMesh dist = with_metric(comm, cube(6, Regions::kTwoTagged), [](Vec3) { return SymTensor{}; });
  mark(dist.mesh);
  for (unsigned seed = 1; seed < 5; ++seed) {
    migrate(comm, dist, scatter(comm, dist, seed));
    expect_marked(dist.mesh);
    ASSERT_NO_THROW(reconcile(comm, dist));
  }
  for (int r = comm.size() - 1; r >= 0; --r) {  // ranks without vertices do not lose the columns of the others
    migrate(comm, dist, IdVector<TetId, Rank>(dist.mesh.tet_slots(), Rank{r}));
    expect_marked(dist.mesh);
  }
  migrate(comm, dist, scatter(comm, dist, 7));
  compact(dist);
  expect_marked(dist.mesh);
  reconcile(comm, dist);
}

TEST(VertColumns, FollowThroughBandsOfARank) {
  const Comm& comm = world();
  DistMesh dist = with_metric(comm, cube(6, Regions::kTwoTagged), [](Vec3) { return SymTensor{}; });
  mark(dist.mesh);
  dist.mesh.metric = {};
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    if (dist.mesh.coords[v].x < 0.4) dist.mesh.vert_state[v] |= kActive;
  }
  Band band = cut_band(dist.mesh, 1, 2);
  expect_marked(band.mesh);
  put_back(dist, band, frozen_stay(band.mesh), 2);
  EXPECT_TRUE(dist.mesh.metric.empty());  // it was not there
  measure_metric(dist.mesh);
  expect_marked(dist.mesh);
  EXPECT_EQ(dist.vert2gid.size(), dist.mesh.vert_slots());
}

}  // namespace
}  // namespace skein::test
