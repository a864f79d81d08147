// Faces that meet without being one face are found wherever they are; bodies that only touch are left in peace. Near
// vertices are merged.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "dist/merge_vertices.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

using Move = std::function<Vec3(Vec3)>;

Vec3 shifted(Vec3 x, Vec3 by) { return x + by; }

/// Any place, size and direction.
Move placed(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  const Vec3 a = normalized({any(random), any(random), any(random)});
  const Vec3 b = normalized(cross(a, {any(random), any(random), any(random)})), c = cross(a, b);
  const double scale = std::exp(5 * any(random));
  const Vec3 to = 10 * scale * Vec3{any(random), any(random), any(random)};
  return [=](Vec3 x) { return to + scale * (x.x * a + x.y * b + x.z * c); };
}

void moved(WholeMesh& w, const Move& move) {
  for (Vec3& x : w.coords) x = move(x);
}

/// Both meshes in one; vertices at the same place are one if `merge`.
enum class Joint { kMerged, kApart };
WholeMesh both(WholeMesh a, const WholeMesh& b, Joint joint) {
  std::map<std::array<double, 3>, std::int64_t> at;
  const auto key = [](Vec3 x) { return std::array{x.x, x.y, x.z}; };
  if (joint == Joint::kMerged) {
    for (std::size_t i = 0; i < a.coords.size(); ++i) at[key(a.coords[i])] = static_cast<std::int64_t>(i);
  }
  std::vector<std::int64_t> number;
  for (const Vec3 x : b.coords) {
    const auto found = at.find(key(x));
    number.push_back(found != at.end() ? found->second : std::ssize(a.coords));
    if (found == at.end()) a.coords.push_back(x);
  }
  for (auto t : b.tets) {
    for (auto& v : t) v = number[v];
    a.tets.push_back(t);
  }
  for (auto t : b.tris) {
    for (auto& v : t) v = number[v];
    a.tris.push_back(t);
  }
  a.tet_ref.insert(a.tet_ref.end(), b.tet_ref.begin(), b.tet_ref.end());
  a.tri_ref.insert(a.tri_ref.end(), b.tri_ref.begin(), b.tri_ref.end());
  return a;
}

/// A cube with its sides, moved.
WholeMesh block(int n, const Move& move, double size = 1) {
  WholeMesh w = cube(n);
  moved(w, [&](Vec3 x) { return move(size * x); });
  return w;
}
Move by(double x, double y, double z) {
  return [=](Vec3 p) { return shifted(p, {x, y, z}); };
}
/// The next cube in x, as its mirror image would be: diagonals run the other way.
Vec3 mirrored(Vec3 p) { return {1 + p.x, 1 - p.y, p.z}; }

void without_triangles(WholeMesh& w) { w.tris.clear(), w.tri_ref.clear(); }

struct Answer {
  std::string line;  ///< of the refusal
  DistributeReport report;
};
Answer answer(const WholeMesh& w) {
  const Comm& comm = world();
  Answer a;
  try {
    const DistMesh dist = distribute(comm, slices(comm, w), nullptr, {}, &a.report);
    EXPECT_EQ(check(dist.mesh), "");
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInvalidMesh);
    a.line = e.what();
  }
  EXPECT_EQ(a.line, comm.broadcast(a.line));
  return a;
}

/// Refused with these words, wherever it lies.
void expect_refused(const WholeMesh& w, const std::string& words) {
  EXPECT_NE(answer(w).line.find(words), std::string::npos) << answer(w).line;
  for (unsigned seed = 0; seed < 8; ++seed) {
    WholeMesh other = w;
    moved(other, placed(seed));
    const std::string line = answer(other).line;
    EXPECT_NE(line.find(words), std::string::npos) << "seed " << seed << ": " << line;
    EXPECT_NE(line.find("the first with vertices"), std::string::npos) << line;
  }
}
void expect_good(const WholeMesh& w, std::int64_t crack_verts = 0) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    WholeMesh other = w;
    if (seed > 0) moved(other, placed(seed));
    const Answer a = answer(other);
    EXPECT_EQ(a.line, "") << "seed " << seed;
    EXPECT_EQ(a.report.crack_verts, crack_verts) << "seed " << seed;
  }
}

TEST(Conformity, CrossedDiagonals) {
  WholeMesh w = both(cube(3), block(3, mirrored), Joint::kMerged);
  expect_refused(w, "cover each other");
  without_triangles(w);
  expect_refused(w, "cover each other");
}

TEST(Conformity, HangingVertices) {
  WholeMesh w = both(cube(2), block(4, by(1, 0, 0)), Joint::kMerged);
  expect_refused(w, "inside a face or an edge");
  expect_refused(both(block(1, by(0, 0, 0)), block(8, by(1, 0.25, 0.25), 0.125), Joint::kMerged),
                 "inside a face or an edge");
}

TEST(Conformity, VertexOnAnEdge) {
  // Bodies that touch along an edge, of which one has a vertex more there.
  expect_refused(both(cube(2), block(1, by(1, 1, 0)), Joint::kMerged), "inside a face or an edge");
}

TEST(Conformity, Overlap) {
  expect_refused(both(cube(3), block(3, by(0.4, 0.43, 0.37)), Joint::kMerged), "overlap");
  expect_refused(both(cube(2), block(2, by(0.41, 0.42, 0.43), 0.01), Joint::kMerged), "inside other tetrahedra");
}

TEST(Conformity, Unmerged) {
  WholeMesh w = both(cube(3), block(3, by(1, 0, 0)), Joint::kApart);
  without_triangles(w);
  expect_refused(w, "--merge");
}

TEST(Conformity, CrackIsLegal) { expect_good(both(cube(3), block(3, by(1, 0, 0)), Joint::kApart), 16); }

TEST(Conformity, TouchingBodiesAreLegal) {
  expect_good(both(cube(2), block(2, by(1, 0, 0)), Joint::kApart), 9);
  expect_good(both(cube(2), block(2, by(1, 1, 0)), Joint::kMerged));
  expect_good(both(cube(2), block(2, by(1, 1, 1)), Joint::kMerged));
  expect_good(both(cube(2), block(2, by(5, 1, 1)), Joint::kMerged));
}

TEST(Conformity, ThinGapsAndVoidsAreLegal) {
  expect_good(both(cube(3), block(2, by(1 + 1e-6, 0, 0)), Joint::kMerged));
  WholeMesh w = cube(3);  // without the cell in the middle
  w.tets.erase(w.tets.begin() + 13 * 6, w.tets.begin() + 14 * 6);
  w.tet_ref.resize(w.tets.size());
  without_triangles(w);
  expect_good(w);
}

TEST(Conformity, ThinLayersAreLegal) {
  WholeMesh w = cube(6);
  moved(w, [](Vec3 x) { return Vec3{x.x, x.y, std::expm1(18 * x.z) * 1e-8}; });
  expect_good(w);
}

/// Collective. `w` with near vertices merged.
MeshSlice merged(const WholeMesh& w, double tolerance, MergeReport& report, FieldSlice* values = nullptr) {
  MeshSlice m = slices(world(), w);
  for (auto& r : m.vert_ref) r = 3;
  report = merge_vertices(world(), tolerance, m, values);
  return m;
}

TEST(Merge, UnmergedBodiesBecomeOne) {
  const Comm& comm = world();
  WholeMesh w = both(cube(4), block(4, by(1, 0, 0)), Joint::kApart);
  MergeReport report;
  const MeshSlice m = merged(w, 0, report);
  EXPECT_EQ(report.verts, 25);
  EXPECT_EQ(report.triangles, 32);  // both bodies list the faces between them
  EXPECT_EQ(report.tets, 0);
  MergeReport none;
  const MeshSlice before = merged(both(cube(4), block(4, by(1, 0, 0)), Joint::kMerged), 0, none);
  EXPECT_EQ(content(comm, before).tets, content(comm, m).tets);
  EXPECT_EQ(content(comm, before).verts, content(comm, m).verts);
  DistributeReport found;
  const DistMesh dist = distribute(comm, m, nullptr, {}, &found);
  EXPECT_EQ(dist.global_verts, 225);
  EXPECT_EQ(found.unused_verts + found.crack_verts, 0);
}

TEST(Merge, NearVerticesAndListsFollow) {
  const Comm& comm = world();
  WholeMesh w = both(cube(4), block(4, by(1, 0, 0)), Joint::kApart);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1e-9, 1e-9);
  for (Vec3& x : w.coords) x += {any(random), any(random), any(random)};
  const auto last = static_cast<std::int64_t>(w.tris.size()) - 1;
  w.corners = {0, 125};
  w.required_tris = {0, last};
  w.edges = {{0, 1}, {4, 125}, {125, 126}};  // the second one collapses
  w.edge_ref = {1, 2, 3};
  w.ridges = {0, 1, 2};
  MeshSlice m = slices(comm, w);
  FieldSlice f = fields(m);
  const MergeReport report = merge_vertices(comm, 1e-8, m, &f);
  EXPECT_EQ(report.verts, 25);
  EXPECT_EQ(report.edges, 1);
  EXPECT_EQ(m.edges.total, 2);
  EXPECT_EQ(comm.all_gather(m.ridges.verts), (std::vector{GlobalId{0}, GlobalId{1}}));
  EXPECT_EQ(comm.all_gather(m.required_triangles.verts).back(), GlobalId{last - 32});
  const auto values = comm.all_gather(f.values);
  ASSERT_EQ(values.size(), 7u * 225);
  const auto coords = comm.all_gather(m.coords);
  for (std::size_t v = 0; v < 225; ++v) EXPECT_EQ(values[7 * v + 6], coords[v].x + 2 * coords[v].y + 4 * coords[v].z);
  EXPECT_EQ(distribute(comm, m, &f).global_verts, 225);
}

TEST(Merge, CollapsedTetrahedraGo) {
  const Comm& comm = world();
  WholeMesh w = cube(4);
  moved(w, [](Vec3 x) { return x.x == 1 ? Vec3{0.75 + 1e-7, x.y, x.z} : x; });  // the last layer of cells
  MergeReport report;
  const MeshSlice m = merged(w, 1e-6, report);
  EXPECT_EQ(report.verts, 25);
  EXPECT_EQ(report.tets, 96);
  EXPECT_NEAR(measure(comm, distribute(comm, m)).volume, 0.75, 1e-9);
}

}  // namespace
}  // namespace skein::test
