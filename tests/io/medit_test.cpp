// Medit text meshes: layouts of the text, round trips, bytes that do not depend on the ranks, errors with their lines.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "io/mesh_io.hpp"
#include "io/text_file.hpp"
#include "tests/io/sample.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

MeshSlice read_text(const std::string& text) {
  const Folder folder(world());
  return join(world(), read_mesh(world(), folder.write("text.mesh", text)));
}

/// Reads the text and checks that the error names the file and contains the parts.
void expect_error(const std::string& text, std::vector<std::string> parts) {
  const Folder folder(world());
  const std::string path = folder.write("bad.mesh", text);
  parts.push_back(path);
  expect_contains(error_line(world(), [&] { read_mesh(world(), path); }), parts);
}

const std::string kHead = "MeshVersionFormatted 2\nDimension 3\n";               // lines 1 and 2
const std::string kVerts = "Vertices\n4\n0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\n";  // 3 to 8
const std::string kTets = "Tetrahedra\n1\n1 2 3 4 -5\n";                         // 9 to 11

void expect_one_tet(const MeshSlice& m) {
  EXPECT_EQ(m.total_verts, 4);
  EXPECT_EQ(m.tets.total, 1);
  if (m.total_verts != 4 || m.tets.total != 1) return;
  EXPECT_EQ(m.coords[1], (Vec3{1, 0, 0}));
  EXPECT_EQ(m.coords[3], (Vec3{0, 0, 1}));
  EXPECT_EQ(m.vert_ref, (std::vector<std::int32_t>{1, 2, 3, 4}));
  EXPECT_EQ(m.tets.verts[0], (std::array{GlobalId{0}, GlobalId{1}, GlobalId{2}, GlobalId{3}}));
  EXPECT_EQ(m.tets.ref[0], -5);
}

TEST(Medit, RoundTripAndSameBytesAtAnyRanks) {
  const MeshSlice whole = whole_box(4);
  const Folder folder(world());
  for (const bool even : {true, false}) {
    const std::string path = folder / (even ? "even.mesh" : "uneven.mesh");
    write_mesh(world(), path, cut(whole, world(), even));
    expect_same(join(world(), read_mesh(world(), path)), whole);
  }
  const Comm self = Comm::self();
  if (world().is_root()) {
    write_mesh(self, folder / "one.mesh", whole);
    const auto one = bytes_of_file(folder / "one.mesh");
    EXPECT_FALSE(one.empty());
    EXPECT_TRUE(bytes_of_file(folder / "even.mesh") == one);
    EXPECT_TRUE(bytes_of_file(folder / "uneven.mesh") == one);
  }
}

TEST(Medit, TextAndBinaryAreTheSameMesh) {
  const MeshSlice whole = whole_box(3);
  const Folder folder(world());
  write_mesh(world(), folder / "a.mesh", cut(whole, world()));
  write_mesh(world(), folder / "a.meshb", read_mesh(world(), folder / "a.mesh"));
  expect_same(join(world(), read_mesh(world(), folder / "a.meshb")), whole);
}

TEST(Medit, LayoutsOfTheText) {
  expect_one_tet(read_text(kHead + kVerts + kTets + "End\n"));
  expect_one_tet(read_text(kHead + kVerts + kTets));                   // no End
  expect_one_tet(read_text(kHead + kTets + "\n\n" + kVerts + "End"));  // other order, no last line end
  expect_one_tet(read_text("# made by hand\n\nMeshVersionFormatted\n1\n\nDimension\n3\n" + kVerts +
                           "Tetrahedra 1 # one\n# and its vertices: 1 1 1 1\n1 2\n 3 4\t-5\nEnd\n"));
  expect_one_tet(
      read_text("MeshVersionFormatted 2 Dimension 3 Vertices 4 0 0 0 1 1 0 0 2 0 1 0 3 0 0 1 4 "
                "Tetrahedra 1 1 2 3 4 -5 End"));
  const std::string plain = kHead + kVerts + kTets + "End\n";
  std::string windows;
  for (const char c : plain) {
    if (c == '\n') windows += '\r';
    windows += c;
  }
  expect_one_tet(read_text(windows));
  expect_one_tet(read_text(kHead + "Vertices 4\n0d0 +0.0 0e+00 1\n1D+0 0. 0 2\n.0 10.E-1 -0d3 3\n0 0 1 4\n" + kTets));
  expect_one_tet(read_text(kHead + "VertexOnGeometricVertex\n1\n1 1 0.5\n" + kVerts + "Quadrilaterals\n0\n" + kTets +
                           "SomethingElse\n2 3 4\nEnd\nwhat follows is not read 1 2 3\n"));
  expect_one_tet(read_text(kHead + kVerts + "# " + std::string(3000, 'x') + "\n" + std::string(3000, '\n') + kTets));
}

TEST(Medit, NumbersReadAsTheStandardLibraryReadsThem) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t bits = random();
    double wanted = 0;
    std::memcpy(&wanted, &bits, sizeof wanted);
    if (!std::isfinite(wanted)) continue;
    char text[64];
    const int n = std::snprintf(text, sizeof text, "%.17g", wanted);
    if (i % 2 == 1) std::replace(text, text + n, 'e', 'D');
    const char* p = text;
    double value = 0;
    EXPECT_TRUE(io::parse_number(p, text + n, value)) << text;
    EXPECT_EQ(value, wanted);
    EXPECT_EQ(p, text + n);
  }
  for (const std::string_view text : {"1e-400", "1d-400"}) {
    const char* p = text.data();
    double value = 1;
    EXPECT_TRUE(io::parse_number(p, text.data() + text.size(), value));
    EXPECT_EQ(value, 0);
  }
  for (const std::string_view text : {"", "+", "-", "--1", "+-1", "1.5.2", "1e", "0x10", "1,5", "e5", "12a"}) {
    const char* p = text.data();
    double value = 0;
    EXPECT_FALSE(io::parse_number(p, text.data() + text.size(), value)) << text;
  }
}

TEST(MeditErrors, OtherFiles) {
  expect_error("", {"empty"});
  expect_error("solid cube\nfacet 1 2 3\n", {"MeshVersionFormatted"});
  expect_error(std::string("\1\0\0\0\3\0\0\0", 8), {"not a text file", ".meshb"});
  expect_error(kHead + "SolAtVertices\n1\n1 1\n3.5\nEnd\n", {"no Vertices"});
  std::string words = kHead;
  for (int i = 0; i < 9000; ++i) words += "word ";
  expect_error(words + kVerts, {});
}

TEST(MeditErrors, HeadsAndCounts) {
  expect_error("MeshVersionFormatted 2\n" + kVerts, {"no Dimension"});
  expect_error("MeshVersionFormatted 2\n\nDimension\n2\n" + kVerts, {"line 3", "Dimension is 2"});
  expect_error(kHead + "Vertices\n-4\n", {"line 3", "Vertices", "negative count -4"});
  expect_error(kHead + "Vertices\nEnd\n", {"line 3", "Vertices", "number of entries"});
  expect_error(kHead + "Vertices 4.5\n", {"line 3", "Vertices", "number of entries"});
  expect_error(kHead + "Vertices 99999999999999999999\n", {"line 3", "Vertices", "number of entries"});
  expect_error(kHead + kVerts + kVerts, {"line 9", "Vertices", "second time"});
  expect_error(kHead + kVerts + "Hexahedra\n1\n1 2 3 4 1 2 3 4 0\n", {"line 9", "Hexahedra", "split"});
}

TEST(MeditErrors, TooFewAndTooManyNumbers) {
  expect_error(kHead + "Vertices\n4\n0 0 0 1\n1 0 0 2\n0 1 0 3\n" + kTets,
               {"line 3", "Vertices announces 4 entries", "12 numbers", "'Tetrahedra' in line 8", "cut short"});
  expect_error(kHead + kVerts + "Tetrahedra\n2\n1 2 3 4 -5\n", {"line 9", "Tetrahedra announces 2", "end of the file"});
  expect_error(kHead + kVerts + "Tetrahedra\n1\n1 2 3 4 -5\n1 2 3 4 -5\nEnd\n", {"line 9", "Tetrahedra announces 1"});
  expect_error(kHead + kVerts + "Tetrahedra\n1000000000000000000\n1 2 3 4 -5\nEnd\n",
               {"line 9", "Tetrahedra announces 1000000000000000000"});
  expect_error(kHead + "Vertices\n4\n0 0 0 1\n1 O 0 2\n0 1 0 3\n0 0 1 4\n" + kTets, {"line 3", "'O' in line 6"});
}

TEST(MeditErrors, BadNumbersWithTheirLine) {
  expect_error(kHead + kVerts + "Tetrahedra\n1\n1 2 3 5 -5\n", {"line 11", "tetrahedron 1 names vertex 5", "1 to 4"});
  expect_error(kHead + kVerts + "Triangles\n2\n1 2 3 0\n0 2 3 0\n" + kTets, {"line 12", "triangle 2 names vertex 0"});
  expect_error(kHead + kVerts + "Ridges\n1\n1\n", {"line 11", "ridge 1 names edge 1", "no Edges"});
  expect_error(kHead + kVerts + "Tetrahedra\n1\n1 2 3.0 4 -5\n", {"line 11", "'3.0' is not a whole number"});
  expect_error(kHead + kVerts + "Tetrahedra\n1\n1 2 3 4 5000000000\n", {"line 11", "reference 5000000000"});
  expect_error(kHead + "Vertices\n4\n0 0 0 1\n1 0..1 0 2\n0 1 0 3\n0 0 1 4\n" + kTets,
               {"line 6", "'0..1' is not a number"});
  expect_error(kHead + "Vertices\n4\n0 0 0 1\n1 0 0 2\n0 1 0 3.5\n0 0 1 4\n" + kTets, {"line 7", "vertex 3"});
  for (const char* bad : {"nan", "NaN", "-inf", "Infinity", "1e999", "-NAN"}) {
    std::string text = kHead + "Vertices\n4\n0 0 0 1\n1 0 0 2\n0 1 ";
    text.append(bad).append(" 3\n0 0 1 4\n").append(kTets);
    expect_error(text, {"line 7", "vertex 3", "not a finite"});
  }
}

TEST(MeditErrors, EveryTruncationEndsWithAnErrorOrWhatIsThere) {
  const Folder folder(world());
  const std::string text = kHead + kVerts + kTets;
  for (std::size_t n = 0; n < text.size(); ++n) {
    const std::string path = folder.write("cut.mesh", text.substr(0, n));
    const std::string line = error_or_success(world(), [&] { read_mesh(world(), path); });
    if (!line.empty()) expect_contains(line, {path});
    EXPECT_TRUE(n >= (kHead + kVerts).size() - 1 || !line.empty()) << n;
  }
}

TEST(MeditErrors, AnyDamageEndsWithAnErrorOrAMesh) {
  const Folder folder(world());
  std::mt19937 random(3);
  const std::string good = kHead + kVerts + "Edges 1 1 2 3\nRidges 1 1\n" + kTets + "End\n";
  for (int i = 0; i < 64; ++i) {
    std::string text = good;
    for (int k = 0; k < 2; ++k) text[random() % text.size()] = "0123456789 -.e#\nVzT\"+"[random() % 21];
    const std::string path = folder.write("damaged.mesh", text);
    const std::string line = error_or_success(world(), [&] { read_mesh(world(), path); });
    if (!line.empty()) expect_contains(line, {path});
  }
}

}  // namespace
}  // namespace skein::test
