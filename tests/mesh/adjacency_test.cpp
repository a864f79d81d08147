// build_adjacency, mark_boundary_vertices and compact.
#include "mesh/adjacency.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/error.hpp"
#include "mesh/check.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::test {
namespace {

MeshSpec any_spec() {
  MeshSpec spec;
  spec.two_regions = *rc::gen::arbitrary<bool>();
  spec.n = spec.two_regions ? 2 * *rc::gen::inRange(1, 3) : *rc::gen::inRange(1, 6);
  spec.shape = *rc::gen::element(Shape::kBox, Shape::kSkewed, Shape::kCylinder, Shape::kSphere);
  spec.required = *rc::gen::arbitrary<bool>();
  spec.perturb = *rc::gen::element(0.0, 0.3);
  spec.seed = *rc::gen::arbitrary<unsigned>();
  return spec;
}

RC_GTEST_PROP(Meshes, AreValid, ()) {
  const MeshSpec spec = any_spec();
  const TetMesh m = make_mesh(spec);
  RC_ASSERT(check(m) == "");
  RC_ASSERT(count_tets(m) == static_cast<std::size_t>(6 * spec.n * spec.n * spec.n));
  if (spec.shape == Shape::kBox) {
    RC_ASSERT(std::abs(volume(m) - 1) < 1e-12);
    for (int p = 0; p < 6; ++p) RC_ASSERT(std::abs(patch_area(m, p) - 1) < 1e-12);
    RC_ASSERT(std::abs(patch_area(m, 6) - (spec.two_regions ? 2 : 0)) < 1e-12);
  }
  RC_ASSERT(measure(m).fixed.size() >= (spec.two_regions ? 12u : 8u));
}

RC_GTEST_PROP(BuildAdjacency, MatchesEqualFaces, (std::uint32_t seed)) {
  TetMesh m = make_mesh(any_spec());
  std::mt19937 random(seed);
  std::shuffle(m.tet2vert.begin(), m.tet2vert.end(), random);
  build_adjacency(m);
  std::map<std::array<VertId, 3>, std::vector<FaceId>> model;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t f = 0; f < 4; ++f) {
      auto v = m.verts(make_face(t, f));
      std::sort(v.begin(), v.end());
      model[v].push_back(make_face(t, f));
    }
  }
  for (const auto& [verts, faces] : model) {
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const FaceId other = faces.size() == 2 ? faces[1 - i] : kNoFace;
      RC_ASSERT(m.neighbour(faces[i]) == other);
    }
  }
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const auto& tv = m.tet2vert[m.vert2tet[v]];
    RC_ASSERT(std::find(tv.begin(), tv.end(), v) != tv.end());
  }
}

TEST(BuildAdjacency, RefusesAThirdTetrahedronAtAFace) {
  TetMesh m = make_mesh({.n = 1});
  m.tet2vert.push_back(m.tet2vert[TetId{0}]);
  try {
    build_adjacency(m);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInvalidMesh);
    EXPECT_NE(std::string(e.what()).find("more than two tetrahedra"), std::string::npos) << e.what();
  }
}

/// Entities by coordinates, so that numbering does not count.
struct Content {
  std::multiset<std::array<double, 4>> verts;
  std::multiset<std::vector<double>> tets;
  std::multiset<std::vector<double>> edges;
  friend bool operator==(const Content&, const Content&) = default;
};
double flags_of(const TetMesh& m, VertId v) { return double(m.vert_class[v]) + 256.0 * double(m.vert_state[v]); }
Content content(const TetMesh& m) {
  Content c;
  const auto put = [&](std::vector<double>& out, VertId v) {
    const Vec3 x = m.coords[v];
    out.insert(out.end(), {x.x, x.y, x.z});
  };
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const Vec3 x = m.coords[v];
    if (m.is_live(v)) c.verts.insert({x.x, x.y, x.z, flags_of(m, v) + 65536.0 * m.vert_ref[v]});
  }
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    std::vector<double> item{double(m.tet_ref[t])};
    for (std::size_t i = 0; i < 4; ++i) {
      put(item, m.tet2vert[t][i]);
      item.push_back(m.face_tag[t][i]);
    }
    c.tets.insert(item);
  }
  for (const auto& e : m.features.list()) {
    std::vector<double> a, b;
    put(a, e.a);
    put(b, e.b);
    if (b < a) std::swap(a, b);
    a.insert(a.end(), b.begin(), b.end());
    a.push_back(e.ref);
    c.edges.insert(a);
  }
  return c;
}

RC_GTEST_PROP(Compact, KeepsEverythingThatLives, (std::uint32_t seed)) {
  TetMesh m = make_mesh(any_spec());
  std::mt19937 random(seed);
  // Free some tetrahedra, with what hangs on them alone.
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (random() % 4 != 0 || idx(t) == 0) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceId other = m.tet2face[t][f];
      if (other != kNoFace) m.neighbour(other) = kNoFace;
    }
    m.tet2vert[t] = {kNoVert, kNoVert, kNoVert, kNoVert};
  }
  m.vert2tet.assign(m.vert_slots(), kNoTet);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (const VertId v : m.tet2vert[t]) m.vert2tet[v] = t;
  }
  const auto features = m.features.list();
  for (const auto& e : features) {
    if (!m.is_live(e.a) || !m.is_live(e.b)) m.features.erase(e.a, e.b);
  }
  RC_ASSERT(check(m) == "");
  const Content before = content(m);
  const TetMesh old = m;
  const auto old2new = compact(m);
  RC_ASSERT(check(m) == "");
  RC_ASSERT(content(m) == before);
  RC_ASSERT(m.tet_slots() == count_tets(old));
  for (const VertId v : IdRange<VertId>(old.vert_slots())) {
    RC_ASSERT((old2new[v] == kNoVert) == !old.is_live(v));
    if (old.is_live(v)) RC_ASSERT(m.coords[old2new[v]] == old.coords[v]);
  }
  // Once more changes nothing but nothing at all.
  const TetMesh once = m;
  compact(m);
  RC_ASSERT(m.tet2vert == once.tet2vert && m.tet2face == once.tet2face && m.coords == once.coords);
}

RC_GTEST_PROP(Check, SeesWhatIsDamaged, (std::uint32_t seed)) {
  TetMesh m = make_mesh({.n = 3, .two_regions = false, .seed = seed});
  std::mt19937 random(seed);
  const TetId t{static_cast<int>(random() % m.tet_slots())};
  const std::size_t f = random() % 4;
  switch (*rc::gen::inRange(0, 5)) {
    case 0:
      std::swap(m.tet2vert[t][0], m.tet2vert[t][1]);
      break;
    case 1:
      m.tet2face[t][f] = m.tet2face[t][f] == kNoFace ? make_face(t, 0) : kNoFace;
      RC_PRE(m.tet2face[t][f] != kNoFace || !is_hull(m.face_tag[t][f]));
      break;
    case 2:
      m.face_tag[t][f] = m.face_tag[t][f] == 0 ? kHullFace | 1 : m.face_tag[t][f] + 20;
      break;
    case 3:
      m.vert2tet[m.tet2vert[t][f]] = kNoTet;
      break;
    default:
      m.vert_class[m.features.list()[random() % m.features.size()].a] = {};
  }
  RC_ASSERT(check(m) != "");
}

}  // namespace
}  // namespace skein::test
