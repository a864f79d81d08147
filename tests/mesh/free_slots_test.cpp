// Gaps filled from the end, and layers round vertices.
#include "mesh/free_slots.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <tuple>

#include "mesh/check.hpp"
#include "mesh/surroundings.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::test {
namespace {

/// Any of the n first numbers, ascending.
template <class Id>
std::vector<Id> any_of_first(std::size_t n) {
  std::mt19937 random(*rc::gen::arbitrary<std::uint32_t>());
  std::vector<Id> out;
  const unsigned one_in = *rc::gen::inRange(1u, 6u);
  for (const Id i : IdRange<Id>(n)) {
    if (random() % one_in == 0) out.push_back(i);
  }
  return out;
}

RC_GTEST_PROP(FillFreeSlots, KeepsTheOthersAndMovesNoMoreThanItMust, ()) {
  const std::size_t n = *rc::gen::inRange<std::size_t>(0, 40);
  const auto free = any_of_first<VertId>(n);
  std::vector<VertId> items;
  for (const VertId v : IdRange<VertId>(n)) items.push_back(v);
  std::size_t moves = 0;
  const std::size_t left = fill_free_slots(free, n, [&](VertId from, VertId to) {
    items[idx(to)] = items[idx(from)];
    ++moves;
  });
  items.resize(left);
  std::sort(items.begin(), items.end());
  std::vector<VertId> all, kept;
  for (const VertId v : IdRange<VertId>(n)) all.push_back(v);
  std::set_difference(all.begin(), all.end(), free.begin(), free.end(), std::back_inserter(kept));
  RC_ASSERT(items == kept);
  const auto below = std::count_if(free.begin(), free.end(), [&](VertId v) { return idx(v) < left; });
  RC_ASSERT(moves == static_cast<std::size_t>(below));
}

using Corners = std::vector<std::array<double, 3>>;
using Tets = std::vector<std::tuple<Corners, std::int32_t, std::array<FaceTag, 4>>>;

std::array<double, 3> place(const TetMesh& m, VertId v) { return {m.coords[v].x, m.coords[v].y, m.coords[v].z}; }
Tets tets_of(const TetMesh& m, const IdVector<TetId, char>& gone) {
  Tets out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (gone[t] != 0) continue;
    Corners corners;
    for (const VertId v : m.tet2vert[t]) corners.push_back(place(m, v));
    out.emplace_back(corners, m.tet_ref[t], m.face_tag[t]);
  }
  std::sort(out.begin(), out.end());
  return out;
}
Corners features_of_mesh(const TetMesh& m) {
  Corners out;
  for (const FeatureEdge& e : m.features.list()) {
    const auto [a, b] = std::minmax({place(m, e.a), place(m, e.b)});
    out.push_back(a);
    out.push_back(b);
    out.push_back({static_cast<double>(e.ref), static_cast<double>(e.edge_class), 0});
  }
  return out;
}

RC_GTEST_PROP(FillFreePlaces, LeavesAValidMeshOfWhatStays, ()) {
  MeshSpec spec;
  spec.n = *rc::gen::inRange(1, 5);
  spec.seed = *rc::gen::arbitrary<unsigned>();
  TetMesh m = make_mesh(spec);
  const auto free_tets = any_of_first<TetId>(m.tet_slots());
  IdVector<TetId, char> gone(m.tet_slots(), 0);
  for (const TetId t : free_tets) gone[t] = 1;
  const Tets before = tets_of(m, gone);
  IdVector<VertId, TetId> tet_at(m.vert_slots(), kNoTet);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (gone[t] == 0) tet_at[m.tet2vert[t][k]] = t;
      const FaceId f = m.tet2face[t][k];
      if (gone[t] == 0 || f == kNoFace) continue;
      m.neighbour(f) = kNoFace;
    }
  }
  m.vert2tet = tet_at;
  std::vector<VertId> free_verts;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (tet_at[v] == kNoTet) free_verts.push_back(v);
  }
  const std::vector<FeatureEdge> edges = m.features.list();
  for (const FeatureEdge& e : edges) {
    if (tet_at[e.a] == kNoTet || tet_at[e.b] == kNoTet) m.features.erase(e.a, e.b);
  }
  Corners features = features_of_mesh(m);
  for (const Vec3 x : m.coords) m.anchor.push_back({x, {}});  // goes with the vertices
  const std::size_t verts = m.vert_slots() - free_verts.size();
  std::vector<VertId> followed;
  std::vector<std::array<double, 3>> places;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (tet_at[v] == kNoTet) continue;
    followed.push_back(v);
    places.push_back(place(m, v));
  }

  fill_free_tets(m, free_tets);
  const MovedVerts now = fill_free_verts(m, free_verts);
  RC_ASSERT(m.vert_slots() == verts);
  RC_ASSERT(check(m) == "");
  gone.assign(m.tet_slots(), 0);
  RC_ASSERT(tets_of(m, gone) == before);
  for (std::size_t i = 0; i < followed.size(); ++i) RC_ASSERT(place(m, now(followed[i])) == places[i]);
  for (const VertId v : IdRange<VertId>(verts)) RC_ASSERT(m.anchor[v].x == m.coords[v]);
  Corners features_now = features_of_mesh(m);
  std::sort(features.begin(), features.end());
  std::sort(features_now.begin(), features_now.end());
  RC_ASSERT(features_now == features);
}

RC_GTEST_PROP(LinkEqualFaces, UndoesACut, ()) {
  MeshSpec spec;
  spec.n = *rc::gen::inRange(1, 5);
  TetMesh m = make_mesh(spec);
  const auto before = m.tet2face;
  std::vector<FaceId> faces;
  for (const TetId t : any_of_first<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceId f = m.tet2face[t][k], me = make_face(t, k);
      if (f == kNoFace) continue;
      m.tet2face[t][k] = m.neighbour(f) = kNoFace;
      faces.insert(faces.end(), {me, f});
    }
  }
  const bool apart = *rc::gen::arbitrary<bool>();
  if (apart) {  // of each pair of neighbours one among the others
    std::vector<FaceId> some, others;
    for (const FaceId f : faces) {
      const FaceId g = before[face_tet(f)][face_side(f)];
      (f < g ? some : others).push_back(f);
    }
    link_equal_faces(m, some, others);
  } else {
    link_equal_faces(m, faces);
  }
  RC_ASSERT(m.tet2face == before);
}

RC_GTEST_PROP(Surroundings, WhatIsAddedLaterCountsToo, ()) {
  MeshSpec spec;
  spec.n = *rc::gen::inRange(1, 11);  // layers in the small ones are looked for everywhere, in the others over faces
  const TetMesh m = make_mesh(spec);
  const auto any = [&] { return to_id<VertId>(*rc::gen::inRange<std::size_t>(0, m.vert_slots())); };
  const VertId first = any(), second = any();
  IdVector<VertId, char> seen(m.vert_slots(), 0);
  seen[first] = 1;
  const auto at_seen = [&](TetId t) {
    const auto& v = m.tet2vert[t];
    return (seen[v[0]] | seen[v[1]] | seen[v[2]] | seen[v[3]]) != 0;
  };
  const auto all_at_seen = [&] {
    std::vector<TetId> out;
    for (const TetId t : IdRange<TetId>(m.tet_slots())) {
      if (at_seen(t)) out.push_back(t);
    }
    return out;
  };
  const auto add_layer = [&](Surroundings& s) {
    s.add_vertices();
    s.add_tets();
    for (const TetId t : all_at_seen()) {
      for (const VertId v : m.tet2vert[t]) seen[v] |= 2;
    }
    for (auto& v : seen) v = v != 0 ? 1 : 0;
  };
  Surroundings near(m, {});
  near.add({first});
  add_layer(near);
  RC_ASSERT(near.tets() == all_at_seen());
  near.add({second});
  seen[second] = 1;
  RC_ASSERT(near.tets() == all_at_seen());
  add_layer(near);
  RC_ASSERT(near.tets() == all_at_seen());
}

RC_GTEST_PROP(Surroundings, AreAllWithinSoManyLayers, ()) {
  MeshSpec spec;
  spec.n = *rc::gen::inRange(1, 11);
  const TetMesh m = make_mesh(spec);
  std::vector<VertId> seeds{to_id<VertId>(*rc::gen::inRange<std::size_t>(0, m.vert_slots()))};
  if (*rc::gen::arbitrary<bool>()) seeds.push_back(to_id<VertId>(num(seeds[0]) == 0 ? 1 : 0));
  const int layers = *rc::gen::inRange(0, 3);
  IdVector<VertId, char> seen(m.vert_slots(), 0);
  for (const VertId v : seeds) seen[v] = 1;
  Surroundings near(m, seeds), scanned(m, seeds), added(m, {});
  near.add_tets();
  scanned.add_all_tets();
  added.add(seeds);
  for (int l = 0; l < layers; ++l) {
    const auto inner = seen;
    for (const auto& v : m.tet2vert) {
      if ((inner[v[0]] | inner[v[1]] | inner[v[2]] | inner[v[3]]) == 0) continue;
      for (const VertId w : v) seen[w] = 1;
    }
    for (Surroundings* s : {&near, &scanned, &added}) {
      s->add_vertices();
      s->add_tets();
    }
  }
  std::vector<TetId> expected;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& v = m.tet2vert[t];
    if ((seen[v[0]] | seen[v[1]] | seen[v[2]] | seen[v[3]]) != 0) expected.push_back(t);
  }
  for (const Surroundings* s : {&near, &scanned, &added}) {
    RC_ASSERT(s->tets() == expected);
    for (const VertId v : IdRange<VertId>(seen.size())) RC_ASSERT(s->has(v) == (seen[v] != 0));
  }
}

TEST(Surroundings, MayGrowByTheVerticesOfSomeTetrahedra) {
  MeshSpec spec;
  spec.n = 4;
  const TetMesh m = make_mesh(spec);
  const VertId seed = m.tet2vert[to_id<TetId>(m.tet_slots() / 2)][0];
  const auto wanted = [](TetId t) { return num(t) % 2 == 0; };
  std::vector<char> expected(m.vert_slots(), 0);
  expected[idx(seed)] = 1;
  std::size_t unwanted = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& v = m.tet2vert[t];
    if (std::find(v.begin(), v.end(), seed) == v.end()) continue;
    if (!wanted(t)) ++unwanted;
    for (const VertId w : v) expected[idx(w)] |= wanted(t) ? 1 : 0;
  }
  ASSERT_GT(unwanted, 0u);
  Surroundings near(m, {seed});
  near.add_tets();
  near.add_vertices(wanted);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) EXPECT_EQ(near.has(v), expected[idx(v)] != 0);
}

}  // namespace
}  // namespace skein::test
