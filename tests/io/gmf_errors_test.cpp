// GMF binary files that are damaged or hold what Skein cannot take: the same clear line on every rank.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "io/mesh_io.hpp"
#include "tests/io/gmf_image.hpp"
#include "tests/io/sample.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Reads the image and checks that the error names the file and contains the parts.
void expect_error(const GmfImage& image, std::vector<std::string> parts) {
  const Folder folder(world());
  const std::string path = folder.write("bad.meshb", image.bytes);
  parts.push_back(path);
  expect_contains(error_line(world(), [&] { read_mesh(world(), path); }), parts);
}

/// Dimension, vertices and the tetrahedra of a small box; `change` may spoil the mesh before.
GmfImage box_image(int version, const std::function<void(MeshSlice&)>& change) {
  MeshSlice whole = whole_box(2);
  change(whole);
  GmfImage image(version);
  image.mesh(whole);
  return image;
}

TEST(GmfErrors, MissingEmptyAndOtherFiles) {
  const Folder folder(world());
  expect_contains(error_line(world(), [&] { read_mesh(world(), folder / "no.meshb"); }), {folder / "no.meshb"});
  for (const char* text : {"", "MeshVersionFormatted 2\nDimension 3\n", "abc"}) {
    const std::string path = folder.write("text.meshb", std::string(text));
    expect_contains(error_line(world(), [&] { read_mesh(world(), path); }), {path, "not a GMF binary file"});
  }
  GmfImage future(5);
  future.mesh(whole_box(1));
  expect_error(future, {"version 5"});
}

TEST(GmfErrors, Dimension) {
  GmfImage two(2);
  two.dimension(2);
  two.end();
  expect_error(two, {"Dimension is 2", "dimension 3"});
  GmfImage none(2);
  none.vertices(whole_box(1));
  none.end();
  expect_error(none, {"no Dimension"});
}

TEST(GmfErrors, NoVertices) {
  GmfImage image(3);
  image.dimension(3);
  image.cells(8, whole_box(1).tets);
  image.end();
  expect_error(image, {"no Vertices"});
}

TEST(GmfErrors, NumbersOutOfRange) {
  expect_error(box_image(2, [](MeshSlice& m) { m.tets.verts[40][2] = GlobalId{27}; }),
               {"tetrahedron 41 names vertex 28", "1 to 27"});
  expect_error(box_image(4, [](MeshSlice& m) { m.tets.verts[0][0] = GlobalId{-1}; }), {"tetrahedron 1 names vertex 0"});
  expect_error(box_image(3, [](MeshSlice& m) { m.triangles.verts[5][1] = GlobalId{99}; }),
               {"triangle 6 names vertex 100"});
  expect_error(box_image(3, [](MeshSlice& m) { m.edges.verts[1][1] = GlobalId{-8}; }), {"edge 2 names vertex -7"});
  expect_error(box_image(3, [](MeshSlice& m) { m.corners.verts[2] = GlobalId{27}; }), {"corner 3 names vertex 28"});
  expect_error(box_image(3, [](MeshSlice& m) { m.ridges.verts[1] = GlobalId{2}; }),
               {"ridge 2 names edge 3", "1 to 2 in Edges"});
  expect_error(box_image(3, [](MeshSlice& m) { m.required_triangles.verts[0] = GlobalId{48}; }),
               {"required triangle 1 names triangle 49"});
  expect_error(box_image(3, [](MeshSlice& m) { m.edges = {}; }), {"ridge 1 names edge 2", "has no Edges"});
}

TEST(GmfErrors, TheFirstBadEntityIsNamedAtAnyRanks) {
  expect_error(box_image(2,
                         [](MeshSlice& m) {
                           for (const std::size_t i : {44U, 7U, 30U}) m.tets.verts[i][2] = GlobalId{1000};
                         }),
               {"tetrahedron 8 "});
}

TEST(GmfErrors, ReferenceBeyond32Bits) {
  GmfImage image(4);
  image.dimension(3);
  image.vertices(whole_box(1));
  image.head(8, 1);
  for (const std::int64_t v : {1LL, 2LL, 3LL, 5LL, 5000000000LL}) image.integer(v);
  image.finish();
  image.end();
  expect_error(image, {"reference 5000000000 of tetrahedron 1"});
}

TEST(GmfErrors, CoordinatesThatAreNotFinite) {
  for (const int version : {1, 2}) {
    expect_error(box_image(version, [](MeshSlice& m) { m.coords[20].y = kNan; }), {"vertex 21", "not a finite"});
    expect_error(box_image(version, [](MeshSlice& m) { m.coords[0].z = -HUGE_VAL; }), {"vertex 1 ", "not a finite"});
  }
}

TEST(GmfErrors, OtherElements) {
  const std::vector<std::pair<std::int32_t, std::string>> others{
      {7, "Quadrilaterals"}, {9, "Prisms"}, {10, "Hexahedra"}, {49, "Pyramids"}, {30, "TetrahedraP2"}};
  for (const auto& [keyword, name] : others) {
    GmfImage image(3);
    image.dimension(3);
    image.vertices(whole_box(1));
    image.head(keyword, 2);
    for (int i = 0; i < 22; ++i) image.integer(1);
    image.finish();
    image.end();
    expect_error(image, {name, "2 ", "split"});
  }
}

TEST(GmfErrors, CountsThatCannotBe) {
  for (const int version : {1, 2, 3, 4}) {
    const std::int64_t largest = version == 4 ? INT64_MAX : INT32_MAX;
    for (const std::int64_t count : {std::int64_t{-1}, largest, largest / 2, std::int64_t{1000}}) {
      GmfImage image(version);
      image.dimension(3);
      image.vertices(whole_box(1));
      image.head(8, count);
      for (int i = 0; i < 10; ++i) image.integer(1);
      image.finish();
      image.end();
      expect_error(image, {"Tetrahedra", std::to_string(count), count < 0 ? "negative" : "truncated"});
    }
  }
}

TEST(GmfErrors, SectionTwice) {
  GmfImage image(3);
  image.dimension(3);
  image.vertices(whole_box(1));
  image.vertices(whole_box(1));
  image.end();
  expect_error(image, {"Vertices", "second time"});
}

TEST(GmfErrors, PositionsThatLeadBack) {
  for (const int version : {2, 3}) {
    GmfImage image(version);
    image.dimension(3);
    image.vertices(whole_box(1));
    // the position of the first keyword is at byte 12
    version == 2 ? image.store(12, std::int32_t{8}) : image.store(12, std::int64_t{8});
    image.end();
    expect_error(image, {"damaged", "byte 8"});
  }
}

TEST(GmfErrors, EveryTruncationIsNoticed) {
  const Folder folder(world());
  for (const int version : {2, 4}) {
    GmfImage image(version);
    image.mesh(whole_box(1));
    const std::size_t end = image.bytes.size() - (version == 2 ? 8 : 12);  // where End begins
    for (std::size_t n = 0; n < end + 4; n += 1 + n / 30) {
      const std::vector<std::byte> head(image.bytes.begin(), image.bytes.begin() + static_cast<std::ptrdiff_t>(n));
      const std::string path = folder.write("cut.meshb", head);
      expect_contains(error_line(world(), [&] { read_mesh(world(), path); }), {path});
    }
  }
}

TEST(GmfErrors, AnyDamageEndsWithAnErrorOrAMesh) {
  const Folder folder(world());
  std::mt19937 random(1);
  for (int i = 0; i < 64; ++i) {
    GmfImage image(1 + i % 4, i % 8 >= 4);
    image.mesh(whole_box(1));
    for (int k = 0; k < 3; ++k) image.bytes[random() % image.bytes.size()] = static_cast<std::byte>(random() % 256);
    const std::string path = folder.write("damaged.meshb", image.bytes);
    const std::string line = error_or_success(world(), [&] { read_mesh(world(), path); });
    if (!line.empty()) expect_contains(line, {path});
  }
}

}  // namespace
}  // namespace skein::test
