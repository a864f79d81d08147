// GMF binary meshes: images of all versions and byte orders, round trips, bytes that do not depend on the ranks.
#include <gtest/gtest.h>

#include "io/formats.hpp"
#include "io/mesh_io.hpp"
#include "tests/io/gmf_image.hpp"
#include "tests/io/sample.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

struct Kind {
  int version;
  bool swap;
};
class GmfImages : public ::testing::TestWithParam<Kind> {};

TEST_P(GmfImages, SlicesOfAllRanksAreTheFile) {
  const auto [version, swap] = GetParam();
  MeshSlice whole = whole_box(3);
  GmfImage image(version, swap);
  image.mesh(whole);
  const Folder folder(world());
  const MeshSlice read = read_mesh(world(), folder.write("image.meshb", image.bytes));
  if (version == 1) {
    for (Vec3& x : whole.coords) x = {float(x.x), float(x.y), float(x.z)};
  }
  expect_same(join(world(), read), whole);
}

TEST_P(GmfImages, MoreRanksThanVertices) {
  const auto [version, swap] = GetParam();
  MeshSlice whole;
  whole.total_verts = 1;
  whole.coords = {{1, 2, 3}};
  whole.vert_ref = {7};
  GmfImage image(version, swap);
  image.dimension(3);
  image.vertices(whole);
  image.end();
  const Folder folder(world());
  expect_same(join(world(), read_mesh(world(), folder.write("one.meshb", image.bytes))), whole);
}

INSTANTIATE_TEST_SUITE_P(AllKinds, GmfImages,
                         ::testing::Values(Kind{1, false}, Kind{2, false}, Kind{3, false}, Kind{4, false},
                                           Kind{1, true}, Kind{2, true}, Kind{3, true}, Kind{4, true}));

class GmfVersions : public ::testing::TestWithParam<GmfVersion> {};

TEST_P(GmfVersions, RoundTripAndSameBytesAtAnyRanks) {
  const MeshSlice whole = whole_box(4);
  const Folder folder(world());
  for (const bool even : {true, false}) {
    const std::string path = folder / (even ? "even.meshb" : "uneven.meshb");
    io::write_gmf_mesh(world(), path, cut(whole, world(), even), GetParam());
    expect_same(join(world(), read_mesh(world(), path)), whole);
  }
  const Comm self = Comm::self();
  if (world().is_root()) {
    io::write_gmf_mesh(self, folder / "one.meshb", whole, GetParam());
    const auto one = bytes_of_file(folder / "one.meshb");
    EXPECT_FALSE(one.empty());
    EXPECT_TRUE(bytes_of_file(folder / "even.meshb") == one);
    EXPECT_TRUE(bytes_of_file(folder / "uneven.meshb") == one);
  }
}

INSTANTIATE_TEST_SUITE_P(All, GmfVersions, ::testing::Values(GmfVersion::k2, GmfVersion::k3, GmfVersion::k4));

std::int32_t version_of(const std::string& path) {
  std::int32_t head[2] = {0, 0};
  const auto bytes = bytes_of_file(path);
  std::memcpy(head, bytes.data(), sizeof head);
  EXPECT_EQ(head[0], 1);
  return head[1];
}

TEST(Gmf, VersionIsTwoWhereItFits) {
  const Folder folder(world());
  write_mesh(world(), folder / "a.meshb", cut(whole_box(1), world()));
  EXPECT_EQ(version_of(folder / "a.meshb"), 2);
  write_fields(world(), folder / "a.solb", cut(whole_fields(27), world()));
  EXPECT_EQ(version_of(folder / "a.solb"), 2);
  write_fields(world(), folder / "b.solb", cut(whole_fields(27), world()), GmfVersion::k4);
  EXPECT_EQ(version_of(folder / "b.solb"), 4);
  constexpr std::int64_t kMost = INT32_MAX;
  EXPECT_EQ(io::gmf_version_for(kMost, kMost), 2);
  EXPECT_EQ(io::gmf_version_for(10, kMost + 1), 3);
  EXPECT_EQ(io::gmf_version_for(kMost + 1, 2 * kMost), 4);
}

// A mesh of version 2 is what GmfImage makes of it by hand, section by section: no padding, positions of four bytes.
TEST(Gmf, VersionTwoByteByByte) {
  MeshSlice whole;
  whole.total_verts = 4;
  whole.coords = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  whole.vert_ref = {1, 2, 3, 4};
  whole.tets.total = 1;
  whole.tets.verts = {{GlobalId{0}, GlobalId{1}, GlobalId{2}, GlobalId{3}}};
  whole.tets.ref = {7};
  GmfImage image(2);
  image.dimension(3);
  image.vertices(whole);
  image.cells(8, whole.tets);
  image.end();
  const Folder folder(world());
  write_mesh(world(), folder / "a.meshb", cut(whole, world()));
  EXPECT_TRUE(bytes_of_file(folder / "a.meshb") == image.bytes);
}

TEST(Gmf, SurfaceWithoutTetrahedra) {
  MeshSlice whole = whole_box(2);
  whole.tets = {};
  const Folder folder(world());
  write_mesh(world(), folder / "surface.meshb", cut(whole, world()));
  const MeshSlice back = join(world(), read_mesh(world(), folder / "surface.meshb"));
  EXPECT_EQ(back.tets.total, 0);
  expect_same(back, whole);
}

TEST(Gmf, NothingIsLeftBesideTheFile) {
  const Folder folder(world());
  write_mesh(world(), folder / "a.meshb", cut(whole_box(1), world()));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.meshb"});
  expect_contains(error_line(world(), [&] { write_mesh(world(), folder / "no/a.meshb", cut(whole_box(1), world())); }),
                  {folder / "no"});
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.meshb"});
}

TEST(Gmf, UnknownEndings) {
  const MeshSlice mine = cut(whole_box(1), world());
  expect_contains(error_line(world(), [&] { read_mesh(world(), "a.vtk"); }), {"a.vtk", ".meshb"});
  expect_contains(error_line(world(), [&] { write_mesh(world(), "a.stl", mine); }), {"a.stl", ".pvtu"});
  expect_contains(error_line(world(), [&] { read_fields(world(), "a.meshb"); }), {"a.meshb", ".solb"});
}

TEST(Gmf, OutputsAreTriedBeforeTheRun) {
  const Folder folder(world());
  require_output(world(), folder / "a.meshb");
  require_output(world(), folder / "a.sol");
  EXPECT_TRUE(folder.names().empty());
  expect_contains(error_line(world(), [&] { require_output(world(), folder / "a.stl"); }), {folder / "a.stl", ".pvtu"});
  expect_contains(error_line(world(), [&] { require_output(world(), folder / "no/a.mesh"); }), {folder / "no"});
}

TEST(Gmf, SlicesWithGapsAreRefused) {
  const Folder folder(world());
  MeshSlice mine = cut(whole_box(1), world());
  mine.tets.total += 1;
  EXPECT_THROW(write_mesh(world(), folder / "a.meshb", mine), AgreedError);
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace skein::test
