// Bad input: every rank gets the same clear line with the numbers in the file.
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// The line with which distribute() refuses `whole`; empty if it does not. Checks that all ranks get the same.
std::string refusal(const WholeMesh& whole) {
  const Comm& comm = world();
  std::string line;
  try {
    (void)distribute(comm, slices(comm, whole));
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInvalidMesh);
    line = e.what();
  }
  EXPECT_EQ(line, comm.broadcast(line));
  EXPECT_EQ(line.find('\n'), std::string::npos);
  return line;
}

void expect_parts(const std::string& line, const std::vector<std::string>& parts) {
  for (const auto& p : parts) EXPECT_NE(line.find(p), std::string::npos) << "'" << p << "' is not in: " << line;
}

TEST(Refuse, GoodMeshIsNotRefused) { EXPECT_EQ(refusal(cube(3)), ""); }

TEST(Refuse, RepeatedVertex) {
  WholeMesh w = cube(3);
  w.tets[4][1] = w.tets[4][0];
  w.tets[100][3] = w.tets[100][2];
  expect_parts(refusal(w), {"cube.mesh: ", "repeated vertex", "5, 101", "(2 in all)", "first with vertices"});
}

TEST(Refuse, VertexOutOfRange) {
  WholeMesh w = cube(3);
  w.tets[30][1] = 64;
  expect_parts(refusal(w), {"not in the mesh", "31 ("});
  w = cube(3);
  w.tris[0][0] = -1;
  expect_parts(refusal(w), {"triangles", "not in the mesh", ": 1 ("});
}

TEST(Refuse, CoordinatesNotFinite) {
  WholeMesh w = cube(3);
  w.coords[6].y = std::numeric_limits<double>::quiet_NaN();
  expect_parts(refusal(w), {"not finite", ": 7 ("});
}

TEST(Refuse, Flat) {
  WholeMesh w = cube(1);
  w.coords[7] = w.coords[0];  // the diagonal vanishes
  expect_parts(refusal(w), {"flat tetrahedra", "1, 2, 3, 4, 5, ... (6 in all)", "the first with vertices", "("});
}

TEST(Refuse, TetrahedraWithTwoReferences) {
  WholeMesh w = cube(3);
  w.tets.push_back(w.tets[11]);
  w.tet_ref.push_back(2);
  expect_parts(refusal(w), {"tetrahedra given twice with different references", "12 and 163", "(1 in all)"});
}

TEST(Refuse, CrowdedFace) {
  // Three tetrahedra at the triangle 0 1 2.
  WholeMesh w;
  w.coords = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.1, 0.1, 2}};
  w.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}};
  w.tet_ref = {1, 1, 1};
  expect_parts(refusal(w), {"more than two tetrahedra", "1 and 3", "(0, 0, 0)"});
}

TEST(Refuse, BothOnOneSide) {
  WholeMesh w;
  w.coords = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 2}};
  w.tets = {{0, 1, 2, 3}, {0, 1, 2, 4}};
  w.tet_ref = {1, 1};
  expect_parts(refusal(w), {"on one side", "1 and 2", "(1 in all)", "(0, 0, 0)", "(1, 0, 0)"});
}

TEST(Refuse, StrayTriangle) {
  WholeMesh w = cube(3);
  w.tris.push_back({0, 21, 63});
  w.tri_ref.push_back(3);
  expect_parts(refusal(w), {"no face of a tetrahedron", std::to_string(w.tris.size()) + " (1 in all)", "22 ("});
}

TEST(Refuse, TrianglesWithTwoReferences) {
  WholeMesh w = cube(3);
  w.tris.push_back({w.tris[9][1], w.tris[9][0], w.tris[9][2]});
  w.tri_ref.push_back(w.tri_ref[9] + 1);
  expect_parts(refusal(w),
               {"triangles given twice with different references", "10 and " + std::to_string(w.tris.size())});
}

TEST(Refuse, FieldsThatDoNotFit) {
  const Comm& comm = world();
  const MeshSlice small = slices(comm, cube(2)), large = slices(comm, cube(3));
  const FieldSlice field = fields(small);
  try {
    (void)distribute(comm, large, &field);
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInput);
    expect_parts(e.what(), {"cube.sol", "27", "64"});
  }
}

}  // namespace
}  // namespace skein::test
