// Check: every fault that it knows is planted, found, counted and named; the ranks do not matter.
#include "report/check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <utility>

#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

constexpr int kCells = 3;

std::int64_t count(const CheckResult& r, Fault f) { return r.counts[static_cast<std::size_t>(f)]; }

std::vector<Finding> findings(const CheckResult& r, Fault f) {
  std::vector<Finding> out;
  for (const Finding& found : r.findings) {
    if (found.fault == f) out.push_back(found);
  }
  return out;
}

void expect_same(const CheckResult& a, const CheckResult& b) {
  EXPECT_EQ(a.valid, b.valid);
  EXPECT_EQ(a.counts, b.counts);
  EXPECT_EQ(a.hull_faces, b.hull_faces);
  EXPECT_EQ(a.hull_euler, b.hull_euler);
  EXPECT_EQ(a.findings.size(), b.findings.size());
  for (std::size_t i = 0; i < std::min(a.findings.size(), b.findings.size()); ++i) {
    const Finding &f = a.findings[i], &g = b.findings[i];
    EXPECT_EQ(f.fault, g.fault);
    EXPECT_EQ(f.entity, g.entity);
    EXPECT_EQ(f.other, g.other);
    EXPECT_EQ(f.verts, g.verts);
  }
}

/// Collective. What all ranks find; it must be what each finds alone.
CheckResult checked(const WholeMesh& w) {
  const CheckResult together = check_mesh(world(), slices(world(), w));
  expect_same(together, check_mesh(Comm::self(), slices(Comm::self(), w)));
  return together;
}

/// Two positive tetrahedra, with all their outer faces as triangles.
WholeMesh two_tets(std::vector<Vec3> coords, std::array<std::int64_t, 4> a, std::array<std::int64_t, 4> b) {
  WholeMesh w;
  w.coords = std::move(coords);
  std::set<std::array<std::int64_t, 3>> once;
  for (auto t : {a, b}) {
    const auto x = [&](std::size_t k) { return w.coords[t[k]]; };
    if (volume6(x(0), x(1), x(2), x(3)) < 0) std::swap(t[2], t[3]);
    w.tets.push_back(t);
    for (const auto& f : kFaceVerts) {
      std::array<std::int64_t, 3> v{t[f[0]], t[f[1]], t[f[2]]};
      std::sort(v.begin(), v.end());
      if (!once.insert(v).second) once.erase(v);
    }
  }
  w.tet_ref = {1, 1};
  w.tris.assign(once.begin(), once.end());
  w.tri_ref.assign(w.tris.size(), 1);
  return w;
}
const std::vector<Vec3> kCorners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 2}, {0.2, -1, 0.1}};

TEST(Check, OfAValidCube) {
  const CheckResult r = checked(cube(kCells));
  EXPECT_TRUE(r.valid);
  EXPECT_FALSE(r.surface_only);
  EXPECT_TRUE(r.findings.empty());
  EXPECT_EQ(r.vertices, 64);
  EXPECT_EQ(r.tets, 162);
  EXPECT_EQ(r.hull_faces, 12 * kCells * kCells);
  EXPECT_EQ(r.triangles, r.hull_faces);
  EXPECT_EQ(r.internal_triangles, 0);
  EXPECT_EQ(r.hull_euler, 2);
  EXPECT_NEAR(r.volume, 1, 1e-13);
  EXPECT_NEAR(r.area, 6, 1e-13);
  EXPECT_NEAR(r.min_volume, 1.0 / 162, 1e-15);
}

TEST(Check, TrianglesBetweenRegionsAreInternal) {
  const CheckResult r = checked(cube(4, Regions::kTwoTagged));
  EXPECT_TRUE(r.valid);
  EXPECT_EQ(r.internal_triangles, 2 * 4 * 4);
  EXPECT_EQ(r.hull_faces + r.internal_triangles, r.triangles);
}

TEST(Check, OfAClosedSurface) {
  WholeMesh w = cube(kCells);
  w.tets.clear(), w.tet_ref.clear();
  const CheckResult r = checked(w);
  EXPECT_TRUE(r.surface_only);
  EXPECT_TRUE(r.valid);
  EXPECT_EQ(r.hull_euler, 2);
  EXPECT_EQ(count(r, Fault::kUnusedVertex), 8);  // the inner ones
}

/// A mesh with a fault, and what must be said of it.
struct Planted {
  Fault fault;
  WholeMesh mesh;
  std::int64_t count;
  std::int64_t entity, other;       ///< of its first finding
  std::vector<std::int64_t> verts;  ///< of its first finding, in any order
  bool valid = false;               ///< it is a warning only
};
std::vector<std::int64_t> sorted(std::vector<std::int64_t> v) {
  std::sort(v.begin(), v.end());
  return v;
}
template <std::size_t N>
std::vector<std::int64_t> numbers(const std::array<std::int64_t, N>& v) {
  return sorted({v.begin(), v.end()});
}

std::vector<Planted> faults_of_tets() {
  std::vector<Planted> all;
  WholeMesh w = cube(kCells);
  std::swap(w.tets[17][0], w.tets[17][1]);
  all.push_back({Fault::kNonpositiveTet, w, 1, 17, -1, numbers(w.tets[17])});
  w = cube(kCells);
  w.tets[4][1] = w.tets[4][0];
  all.push_back({Fault::kDegenerateTet, w, 1, 4, -1, numbers(w.tets[4])});
  w = cube(kCells);
  w.tets.push_back(w.tets[11]), w.tet_ref.push_back(1);
  all.push_back({Fault::kDuplicateTet, w, 1, 162, 11, numbers(w.tets[11])});
  w = two_tets({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.1, 0.1, 2}}, {0, 1, 2, 3}, {0, 1, 2, 4});
  w.tets.push_back({0, 1, 2, 5}), w.tet_ref.push_back(1);
  all.push_back({Fault::kFaceOver2, w, 1, 0, 1, {0, 1, 2}});
  w = two_tets(kCorners, {0, 1, 2, 3}, {0, 1, 2, 4});
  w.coords.pop_back();
  all.push_back({Fault::kMisorientedPair, w, 1, 0, 1, {0, 1, 2}});
  return all;
}

std::vector<Planted> faults_of_triangles() {
  std::vector<Planted> all;
  WholeMesh w = cube(kCells);
  const auto gone = w.tris[5];
  const auto tet = std::find_if(w.tets.begin(), w.tets.end(), [&](const auto& t) {
    return std::all_of(gone.begin(), gone.end(), [&](auto v) { return std::find(t.begin(), t.end(), v) != t.end(); });
  });
  w.tris.erase(w.tris.begin() + 5), w.tri_ref.pop_back();
  all.push_back({Fault::kHullFaceNotTriangle, w, 1, tet - w.tets.begin(), -1, numbers(gone)});
  w = cube(kCells);
  w.tris.push_back({0, 21, 63}), w.tri_ref.push_back(3);
  all.push_back({Fault::kTriangleNotFace, w, 1, 108, -1, {0, 21, 63}});
  w = cube(kCells);
  w.tris.push_back({w.tris[9][1], w.tris[9][0], w.tris[9][2]}), w.tri_ref.push_back(3);
  all.push_back({Fault::kDuplicateTriangle, w, 1, 108, 9, numbers(w.tris[9])});
  w = cube(kCells);
  w.tets.clear(), w.tet_ref.clear();  // a surface with a hole
  const auto hole = w.tris[5];
  w.tris.erase(w.tris.begin() + 5), w.tri_ref.pop_back();
  auto edge = numbers(hole);
  edge.pop_back();
  all.push_back({Fault::kOpenHullEdge, w, 3, -1, -1, edge});
  return all;
}

std::vector<Planted> faults_of_vertices_and_edges() {
  std::vector<Planted> all;
  WholeMesh w = cube(kCells);
  w.coords[6].y = std::numeric_limits<double>::quiet_NaN();
  w.coords[6].z = std::numeric_limits<double>::infinity();
  all.push_back({Fault::kNonfiniteCoordinate, w, 2, 6, -1, {6}});
  w = two_tets({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {0, 1, 2, 3}, {0, 1, 4, 5});
  all.push_back({Fault::kNonmanifoldHullEdge, w, 1, -1, -1, {0, 1}, true});
  w = cube(kCells);
  w.coords.push_back({9, 9, 9});
  all.push_back({Fault::kUnusedVertex, w, 1, 64, -1, {64}, true});
  w = cube(kCells);
  w.coords.push_back(w.coords[5]);
  all.push_back({Fault::kDuplicateVertex, w, 1, 64, 5, {64}, true});
  return all;
}

std::vector<Planted> faults_of_contact() {
  std::vector<Planted> all;
  const Vec3 o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const auto pair = [](std::vector<Vec3> coords) { return two_tets(std::move(coords), {0, 1, 2, 3}, {4, 5, 6, 7}); };
  all.push_back(
      {Fault::kHangingVertex, pair({o, x, y, z, {0.25, 0.25, 0}, {0, 0, -1}, {1, 0, -1}, {0, 1, -1}}), 1, 4, -1, {4}});
  all.push_back({Fault::kCoveringFaces,  // triangles as in a hexagram
                 pair({{0, 0, 0}, {3, 0, 0}, {1.5, 3, 0}, {1, 1, 1}, {0, 2, 0}, {3, 2, 0}, {1.5, -1, 0}, {1, 1, -1}}),
                 1,
                 0,
                 1,
                 {0, 1, 2}});
  const Vec3 s{0.1, 0.1, 0.1};
  all.push_back({Fault::kCrossingTets, pair({o, x, y, z, s, x + s, y + s, z + s}), 1, 0, 1, {1, 2, 3}});
  WholeMesh w = pair({o, x, y, z, o, x, y, -1 * z});
  w.tris.erase(std::find(w.tris.begin(), w.tris.end(), std::array<std::int64_t, 3>{0, 1, 2})), w.tri_ref.pop_back();
  all.push_back({Fault::kUnmergedVertices, w, 3, 0, 4, {0}});
  const Vec3 t{0.01, 0.01, 0.01};
  all.push_back(
      {Fault::kNestedTet, pair({o, x, y, z, s, s + 0.1 * x + t, s + 0.1 * y, s + 0.1 * z}), 1, 1, -1, {4, 5, 6}});
  return all;
}

std::vector<Planted> planted() {
  std::vector<Planted> all = faults_of_tets();
  for (auto* more : {&faults_of_triangles, &faults_of_vertices_and_edges, &faults_of_contact}) {
    for (auto& p : more()) all.push_back(std::move(p));
  }
  return all;
}

TEST(Check, EveryFaultIsFoundCountedAndNamed) {
  std::set<Fault> tried;
  for (const Planted& p : planted()) {
    SCOPED_TRACE(key(p.fault));
    tried.insert(p.fault);
    const CheckResult r = checked(p.mesh);
    EXPECT_EQ(r.valid, p.valid);
    EXPECT_EQ(count(r, p.fault), p.count);
    const auto found = findings(r, p.fault);
    EXPECT_FALSE(found.empty());
    if (found.empty()) continue;
    EXPECT_EQ(found[0].entity, p.entity);
    EXPECT_EQ(found[0].other, p.other);
    std::vector<std::int64_t> verts;
    for (std::size_t k = 0; k < static_cast<std::size_t>(found[0].corners); ++k) {
      verts.push_back(num(found[0].verts[k]));
      const Vec3 x = p.mesh.coords.at(idx(found[0].verts[k]));
      if (is_finite(x)) {
        EXPECT_EQ(found[0].coords[k], x);
      }
    }
    EXPECT_EQ(sorted(verts), p.verts);
    EXPECT_NE(to_json(r).dump().find(key(p.fault)), std::string::npos);
    const std::string text = to_text(r, "planted.mesh");
    const std::string number = std::to_string((p.entity >= 0 ? p.entity : p.verts[0]) + 1);
    EXPECT_NE(text.find(number), std::string::npos) << text;
  }
  EXPECT_EQ(tried.size(), kFaults);
}

TEST(Check, AMeshHasOnlyTheFaultsThatArePlanted) {
  // Those that cannot bring others with them.
  const std::set<Fault> alone{
      Fault::kHullFaceNotTriangle, Fault::kTriangleNotFace, Fault::kDuplicateTriangle, Fault::kUnusedVertex,
      Fault::kNonmanifoldHullEdge, Fault::kHangingVertex,   Fault::kCoveringFaces,     Fault::kNestedTet};
  for (const Planted& p : planted()) {
    if (!alone.contains(p.fault)) continue;
    SCOPED_TRACE(key(p.fault));
    const CheckResult r = checked(p.mesh);
    std::int64_t all = 0;
    for (const std::int64_t n : r.counts) all += n;
    EXPECT_EQ(all, p.count);
  }
}

TEST(Check, AllAreCountedAndTheFirstAreListed) {
  WholeMesh w = cube(kCells);
  for (int i = 0; i < 25; ++i) w.coords.push_back({9.0 + i, 9, 9});
  const CheckResult r = checked(w);
  EXPECT_EQ(count(r, Fault::kUnusedVertex), 25);
  const auto found = findings(r, Fault::kUnusedVertex);
  EXPECT_EQ(found.size(), kMaxFindings);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].entity, 64 + static_cast<std::int64_t>(i));
}

TEST(Check, ASurfaceThatMeetsItselfInAnEdgeIsInvalid) {
  WholeMesh w =
      two_tets({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {0, 1, 2, 3}, {0, 1, 4, 5});
  w.tets.clear(), w.tet_ref.clear();
  const CheckResult r = checked(w);
  EXPECT_EQ(count(r, Fault::kNonmanifoldHullEdge), 1);
  EXPECT_FALSE(r.valid);
}

TEST(Check, NothingIsNoMesh) {
  const CheckResult r = checked({});
  EXPECT_FALSE(r.valid);
  EXPECT_TRUE(r.findings.empty());
}

}  // namespace
}  // namespace skein::test
