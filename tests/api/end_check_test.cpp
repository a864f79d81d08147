// The end check: good runs pass, and each planted fault is found, on any number of ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "api/adaptation.hpp"
#include "report/invariants.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// Entities on the lattice cube that a WholeMesh has no list for.
struct Input {
  WholeMesh whole;
  std::vector<std::int64_t> required_edges, required_tets;
  double size = 0.2;  ///< wanted edge length
};

DistMesh make(const Input& in, bool check_hull = true) {
  const Comm& comm = world();
  MeshSlice file = slices(comm, in.whole);
  cut(comm, in.required_edges, file.required_edges);
  cut(comm, in.required_tets, file.required_tets);
  FieldSlice f;
  f.path = "cube.sol", f.total = file.total_verts, f.first = file.first_vert;
  f.kinds = {FieldKind::kTensor}, f.width = 6;
  const double l = -2 * std::log(in.size);
  for (std::size_t i = 0; i < file.coords.size(); ++i) f.values.insert(f.values.end(), {l, 0, l, 0, 0, l});
  DistributeOptions options;
  options.metric_first = true, options.check_hull = check_hull;
  return distribute(comm, file, &f, options);
}

/// The vertex of the lattice with n cells that is there.
std::int64_t at(int n, int i, int j, int k) { return Lattice{n}.number(i, j, k); }

/// Only the cells (of n per axis) that `keep` names; vertices of none stay unused.
WholeMesh carved(int n, const std::function<bool(int, int, int)>& keep) {
  WholeMesh w = cells(n);
  std::vector<std::array<std::int64_t, 4>> tets;
  for (std::size_t t = 0; t < w.tets.size(); ++t) {
    const auto cell = static_cast<int>(t / 6);
    if (keep(cell % n, cell / n % n, cell / n / n)) tets.push_back(w.tets[t]);
  }
  w.tets = tets;
  w.tet_ref.assign(tets.size(), 1);
  return w;
}

Input plain() { return {cube(4), {}, {}, 0.15}; }
Input regions() { return {cube(4, Regions::kTwoTagged), {}, {}, 0.3}; }
/// A sheet in the middle of the cube with a free rim.
Input baffle() {
  Input in{cube(4, Regions::kTwoTagged), {}, {}, 0.15};
  WholeMesh& w = in.whole;
  w.tet_ref.assign(w.tets.size(), 1);
  std::size_t n = 0;
  for (std::size_t i = 0; i < w.tris.size(); ++i) {
    const bool inside = std::ranges::all_of(w.tris[i], [&](std::int64_t v) {
      const Vec3 x = w.coords[v];
      return x.y >= 0.25 && x.y <= 0.75 && x.z >= 0.25 && x.z <= 0.75;
    });
    if (w.tri_ref[i] == 7 && !inside) continue;
    w.tris[n] = w.tris[i], w.tri_ref[n++] = w.tri_ref[i];
  }
  w.tris.resize(n), w.tri_ref.resize(n);
  return in;
}
Input touching_edge() {
  return {carved(4, [](int i, int j, int) { return (i < 2) == (j < 2); }), {}, {}, 0.15};
}
Input touching_vertex() {
  return {carved(4, [](int i, int j, int k) { return (i < 2) == (j < 2) && (j < 2) == (k < 2); }), {}, {}, 0.15};
}
/// A line of edges through the middle.
Input line_inside() {
  Input in = plain();
  for (int i = 1; i < 3; ++i) {
    in.whole.edges.push_back({at(4, i, 2, 2), at(4, i + 1, 2, 2)});
    in.whole.edge_ref.push_back(9);
  }
  return in;
}
Input required() {
  Input in = plain();
  in.whole.required_verts = {at(4, 1, 1, 1), at(4, 2, 2, 0)};
  in.whole.required_tris = {0, 5};
  in.whole.edges = {{at(4, 1, 1, 0), at(4, 2, 1, 0)}};
  in.whole.edge_ref = {3};
  in.required_edges = {0};
  in.required_tets = {40, 200};
  return in;
}
/// The cube as a ball, coarsened a little.
Input ball() {
  Input in{cube(8), {}, {}, 0.3};
  for (auto& r : in.whole.tri_ref) r = 1;
  for (Vec3& x : in.whole.coords) {
    const Vec3 p = 2.0 * x - Vec3{1, 1, 1};
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), l = norm(p);
    x = l > 0 ? (largest / l) * p : p;
  }
  return in;
}

EndCheckReport after_run(const Input& in) {
  DistMesh dist = make(in);
  const Invariants before = invariants(world(), dist);
  PhaseLog log(world(), PhaseLog::Output::kQuiet);
  adapt(world(), dist, {}, log);
  return compare(before, invariants(world(), dist));
}
void expect_pass(const Input& in) {
  const EndCheckReport r = after_run(in);
  EXPECT_TRUE(r.passed()) << to_line(r);
  EXPECT_GT(r.compared, 10);
}
TEST(GoodRun, Cube) { expect_pass(plain()); }
TEST(GoodRun, Regions) { expect_pass(regions()); }
TEST(GoodRun, Baffle) { expect_pass(baffle()); }
TEST(GoodRun, BodiesThatTouchAlongAnEdge) { expect_pass(touching_edge()); }
TEST(GoodRun, BodiesThatTouchInAVertex) { expect_pass(touching_vertex()); }
TEST(GoodRun, LineInside) { expect_pass(line_inside()); }
TEST(GoodRun, RequiredEntities) { expect_pass(required()); }
TEST(GoodRun, Ball) { expect_pass(ball()); }

TEST(Invariants, DoNotDependOnTheRanks) {
  for (const Input& in : {plain(), regions(), baffle(), touching_edge(), touching_vertex(), required(), ball()}) {
    DistMesh dist = make(in);
    const Invariants before = invariants(world(), dist);
    EXPECT_GT(before.shapes.at(before.patches.size()).components, 0);  // of the hull
    migrate(world(), dist, scatter(world(), dist, 3));
    const EndCheckReport r = compare(before, invariants(world(), dist), {1e-12, 1e-12});
    EXPECT_TRUE(r.passed()) << to_line(r);
  }
}
TEST(Invariants, ShapesOfTheCube) {
  const Invariants i = invariants(world(), make(plain()));
  ASSERT_EQ(i.shapes.size(), 8u);
  for (std::size_t p = 0; p < 6; ++p) EXPECT_EQ(i.shapes[p], (Shape{1, 1}));
  EXPECT_EQ(i.shapes[6], (Shape{2, 1}));
  EXPECT_EQ(i.shapes[7], (Shape{-4, 1}));  // 8 corners, 12 ridges
  for (const Extent& p : i.patches) EXPECT_EQ(p.curved, 0);
  EXPECT_EQ(i.regions.at(0).curved, 0);
  EXPECT_NEAR(i.hull_volume, 1, 1e-12);
  EXPECT_EQ(i.corners.count, 8u);
}

/// Plants a fault into the mesh in parts, and expects that the check names it.
using Plant = std::function<void(DistMesh&)>;
std::string found(const Input& in, const Plant& plant) {
  DistMesh dist = make(in);
  const Invariants before = invariants(world(), dist);
  plant(dist);
  return to_line(compare(before, invariants(world(), dist)));
}
void expect_found(const Input& in, const Plant& plant, const std::string& words) {
  const std::string line = found(in, plant);
  EXPECT_NE(line.find(words), std::string::npos) << "found: " << line;
}
/// Every copy of this vertex.
Plant moved(std::int64_t gid, const std::function<void(Vec3&)>& how) {
  return [=](DistMesh& dist) {
    for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
      if (dist.vert2gid[v] == GlobalId{gid}) how(dist.mesh.coords[v]);
    }
  };
}
/// On one rank only: the lowest one that has tetrahedra.
Plant on_one_rank(const std::function<void(TetMesh&)>& how) {
  return [=](DistMesh& dist) {
    const bool any = dist.mesh.tet_slots() > 0;
    const std::int32_t lowest = world().min(any ? num(world().rank()) : std::numeric_limits<std::int32_t>::max());
    if (num(world().rank()) == lowest) how(dist.mesh);
  };
}
/// The first hull face with this tag's patch, or of the given flag.
template <class Is>
FaceId first_face(const TetMesh& m, Is is) {
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (m.face_tag[t][k] != 0 && is(m.face_tag[t][k])) return make_face(t, k);
    }
  }
  return kNoFace;
}

TEST(Planted, HullVertexOffItsPlane) {
  expect_found(plain(), moved(at(4, 2, 2, 0), [](Vec3& x) { x.z += 1e-5; }), "volume of region 1");
}
TEST(Planted, TetrahedronDropped) {
  expect_found(plain(), on_one_rank([](TetMesh& m) { m.tet2vert.raw().pop_back(); }), "volume of region 1");
}
TEST(Planted, RegionReferenceChanged) {
  expect_found(regions(), on_one_rank([](TetMesh& m) { m.tet_ref[TetId{0}] = 3 - m.tet_ref[TetId{0}]; }),
               "volume of region");
}
TEST(Planted, FacetOfAnotherPatch) {
  expect_found(plain(), on_one_rank([](TetMesh& m) {
                 const FaceId f = first_face(m, [](FaceTag) { return true; });
                 const auto now = static_cast<std::size_t>(tag_patch(m.tag(f)));
                 m.tag(f) = static_cast<FaceTag>(kHullFace | ((now + 1) % 6 + 1));
               }),
               "area of patch");
}
TEST(Planted, RequiredTriangleReplaced) {
  Input other = required();
  other.whole.required_tris = {0, 7};
  const std::string line = to_line(compare(invariants(world(), make(required())), invariants(world(), make(other))));
  EXPECT_NE(line.find("required triangles: one of 2 is another"), std::string::npos) << line;
}
TEST(Planted, RequiredVertexMovedByOneUnitInTheLastPlace) {
  expect_found(required(), moved(at(4, 1, 1, 1), [](Vec3& x) { x.x = std::nextafter(x.x, 1); }), "required vertices");
}
TEST(Planted, FeatureEdgeDropped) {
  expect_found(
      line_inside(),
      [](DistMesh& dist) {
        const auto list = dist.mesh.features.list();
        for (const FeatureEdge& e : list) {
          const auto [a, b] = std::minmax(dist.vert2gid[e.a], dist.vert2gid[e.b]);
          if (e.ref == 9 && a == GlobalId{at(4, 1, 2, 2)}) dist.mesh.features.erase(e.a, e.b);
        }
      },
      "length of feature edges");
}
TEST(Planted, RimFacetRemoved) {
  const Input in = baffle();
  Input less = in;
  for (std::size_t i = 0; i < less.whole.tris.size(); ++i) {
    if (less.whole.tri_ref[i] != 7) continue;
    less.whole.tris.erase(less.whole.tris.begin() + static_cast<std::ptrdiff_t>(i));
    less.whole.tri_ref.erase(less.whole.tri_ref.begin() + static_cast<std::ptrdiff_t>(i));
    break;
  }
  const std::string line = to_line(compare(invariants(world(), make(in)), invariants(world(), make(less))));
  EXPECT_NE(line.find("area of patch 7"), std::string::npos) << line;
}
TEST(Planted, ContactLinePulledApart) {
  const Input in = touching_edge();
  Input apart = in;  // a vertex of the contact line becomes two at one place
  const std::int64_t v = at(4, 2, 2, 1), twin = std::ssize(apart.whole.coords);
  apart.whole.coords.push_back(apart.whole.coords[v]);
  for (auto& t : apart.whole.tets) {
    double x = 0;
    for (const auto g : t) x += in.whole.coords[g].x / 4;
    if (x > 0.5) std::replace(t.begin(), t.end(), v, twin);
  }
  const std::string line = to_line(compare(invariants(world(), make(in)), invariants(world(), make(apart, false))));
  EXPECT_NE(line.find("hull: Euler characteristic"), std::string::npos) << line;
}

TEST(EndCheck, ThrowsAfterTheMeshIsHandedOver) {
  DistMesh dist = make(plain());
  const Invariants before = invariants(world(), dist);
  on_one_rank([](TetMesh& m) { m.tet2vert.raw().pop_back(); })(dist);
  AdaptationOptions options;
  std::size_t handed = 0;
  options.suspect = [&](DistMesh&& d) { handed = d.mesh.vert_slots(); };
  const std::size_t verts = dist.mesh.vert_slots();
  try {
    end_check(world(), before, dist, options);
    ADD_FAILURE() << "passed";
  } catch (const AgreedError& e) {
    EXPECT_EQ(e.code(), ExitCode::kInternal);
    EXPECT_EQ(handed, verts);
  }
}

}  // namespace
}  // namespace skein::test
