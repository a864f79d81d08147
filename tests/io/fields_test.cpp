// Solutions: several fields side by side, in binary and text.
#include <gtest/gtest.h>

#include <limits>

#include "io/formats.hpp"
#include "io/mesh_io.hpp"
#include "tests/io/gmf_image.hpp"
#include "tests/io/sample.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

const std::string kHead = "MeshVersionFormatted 2\nDimension 3\n";

void expect_error(const std::string& name, const auto& content, std::vector<std::string> parts) {
  const Folder folder(world());
  const std::string path = folder.write(name, content);
  parts.push_back(path);
  expect_contains(error_line(world(), [&] { read_fields(world(), path); }), parts);
}

GmfImage image_of(const FieldSlice& f, int version, bool swap) {
  GmfImage image(version, swap);
  image.dimension(3);
  image.skipped();
  image.head(62, f.total);
  image.i32(static_cast<std::int32_t>(f.kinds.size()));
  for (const FieldKind k : f.kinds) image.i32(static_cast<std::int32_t>(k));
  for (const double v : f.values) image.real(v);
  image.finish();
  image.end();
  return image;
}

TEST(Fields, ImagesOfAllVersions) {
  for (int i = 0; i < 8; ++i) {
    FieldSlice whole = whole_fields(37);
    whole.values[2] = 1;  // fits a float
    const int version = 1 + i % 4;
    const GmfImage image = image_of(whole, version, i >= 4);
    const Folder folder(world());
    const FieldSlice read = join(world(), read_fields(world(), folder.write("a.solb", image.bytes)));
    if (version == 1) {
      for (double& v : whole.values) v = static_cast<float>(v);
    }
    expect_same(read, whole);
  }
}

TEST(Fields, RoundTripsAndSameBytesAtAnyRanks) {
  for (const std::int64_t n : {1, 2, 3, 100}) {
    const FieldSlice whole = whole_fields(n);
    const Folder folder(world());
    const Comm self = Comm::self();
    for (const std::string ending : {".sol", ".solb"}) {
      for (const bool even : {true, false}) {
        const std::string path = folder / ((even ? "even" : "uneven") + ending);
        write_fields(world(), path, cut(whole, world(), even));
        expect_same(join(world(), read_fields(world(), path)), whole);
      }
      if (!world().is_root()) continue;
      write_fields(self, folder / ("one" + ending), whole);
      const auto one = bytes_of_file(folder / ("one" + ending));
      EXPECT_TRUE(bytes_of_file(folder / ("even" + ending)) == one);
      EXPECT_TRUE(bytes_of_file(folder / ("uneven" + ending)) == one);
    }
  }
}

TEST(Fields, EachKindAlone) {
  for (const FieldKind kind : {FieldKind::kScalar, FieldKind::kVector, FieldKind::kTensor}) {
    FieldSlice whole;
    whole.total = 11;
    whole.kinds = {kind};
    whole.width = components(kind);
    for (int i = 0; i < 11 * whole.width; ++i) whole.values.push_back(1.0 / (i + 1));
    const Folder folder(world());
    for (const char* name : {"a.sol", "a.solb"}) {
      write_fields(world(), folder / name, cut(whole, world()));
      expect_same(join(world(), read_fields(world(), folder / name)), whole);
    }
  }
}

TEST(Fields, LargeVersionFour) {
  const FieldSlice whole = whole_fields(50);
  const Folder folder(world());
  io::write_gmf_fields(world(), folder / "a.solb", cut(whole, world()), GmfVersion::k4);
  expect_same(join(world(), read_fields(world(), folder / "a.solb")), whole);
}

TEST(FieldErrors, ValuesThatAreNotFinite) {
  FieldSlice whole = whole_fields(20);
  whole.values[13 * 10 + 5] = std::numeric_limits<double>::infinity();  // in the tensor
  expect_error("a.solb", image_of(whole, 2, false).bytes, {"field 2", "vertex 14", "not a finite"});
  whole = whole_fields(20);
  whole.values[19 * 10] = std::numeric_limits<double>::quiet_NaN();
  expect_error("a.solb", image_of(whole, 3, true).bytes, {"field 1", "vertex 20", "not a finite"});
  expect_error("a.sol", kHead + "SolAtVertices\n3\n2 1 2\n0 1 2 3\n4 5 NaN 7\n8 9 1 2\n",
               {"line 7", "field 2", "vertex 2"});
}

TEST(FieldErrors, KindsAndCounts) {
  FieldSlice whole = whole_fields(5);
  whole.kinds[1] = static_cast<FieldKind>(4);
  expect_error("a.solb", image_of(whole, 2, false).bytes, {"field 2", "kind 4"});
  whole.kinds.clear();
  expect_error("a.solb", image_of(whole, 2, false).bytes, {"SolAtVertices", "0 fields"});
  whole = whole_fields(5);
  whole.total = 6;
  expect_error("a.solb", image_of(whole, 2, false).bytes, {"SolAtVertices", "announces 6 records"});
  GmfImage none(3);
  none.mesh(whole_box(1));
  expect_error("a.solb", none.bytes, {"no SolAtVertices"});
  expect_error("a.sol", kHead + "SolAtTetrahedra\n1\n1 1\n3.5\n", {"no SolAtVertices"});
  expect_error("a.sol", kHead + "SolAtVertices\n2\n1 5\n3.5\n3\n", {"line 3", "field 1", "kind 5"});
  expect_error("a.sol", kHead + "SolAtVertices\n2\n3 1 1\n", {"line 3", "kinds"});
  expect_error("a.sol", kHead + "SolAtVertices\n2\n-3 1 1\n", {"line 3", "-3 fields"});
  expect_error("a.sol", kHead + "SolAtVertices\n2\n1.5 1 1\n", {"line 3", "fields"});
  expect_error("a.sol", kHead + "SolAtVertices\n2\n1 3\n1 2 3 4 5 6\n1 2 3 4 5\nEnd\n",
               {"line 3", "announces 2", "'End' in line 8"});
  expect_error("a.sol", kHead + "SolAtVertices\n2\n1 1\n1.5\n2.x\nEnd\n", {"line 7", "'2.x' is not a number"});
}

}  // namespace
}  // namespace skein::test
