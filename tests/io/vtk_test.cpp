// .vtu and .pvtu, opened by VTK itself (check_vtk.py).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "io/mesh_io.hpp"
#include "tests/io/sample.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

double area(const MeshSlice& whole) {
  double sum = 0;
  for (const auto& t : whole.triangles.verts) {
    const Vec3 a = whole.coords[idx(t[0])];
    sum += norm(cross(whole.coords[idx(t[1])] - a, whole.coords[idx(t[2])] - a)) / 2;
  }
  return sum;
}

/// Name, component and range of one column of the fields, as arguments.
std::string range(const FieldSlice& f, std::size_t column, const std::string& name, int component) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (std::size_t i = column; i < f.values.size(); i += static_cast<std::size_t>(f.width)) {
    low = std::min(low, f.values[i]);
    high = std::max(high, f.values[i]);
  }
  return fmt::format(" {} {} {} {}", name, component, low, high);
}

/// Collective. VTK's view of the file must be that of the mesh; points may be more in several pieces (0: not told).
void expect_vtk(const std::string& path, const MeshSlice& whole, std::int64_t points, const std::string& fields) {
  world().barrier();
  if (!world().is_root()) return;
  std::int64_t refs = 0;
  for (const std::int32_t r : whole.tets.ref) refs += r;
  for (const std::int32_t r : whole.triangles.ref) refs += r;
  const std::string command = fmt::format("{} {} {} {} {} {} {} {}{}", SKEIN_VTK_CHECK, path, points, whole.tets.total,
                                          whole.triangles.total, volume(whole), area(whole), refs, fields);
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

/// How many vertices the pieces have together: those that each rank's cells need.
std::int64_t piece_points(const MeshSlice& mine) {
  std::vector<GlobalId> verts;
  for (const auto& t : mine.tets.verts) verts.insert(verts.end(), t.begin(), t.end());
  for (const auto& t : mine.triangles.verts) verts.insert(verts.end(), t.begin(), t.end());
  std::ranges::sort(verts);
  verts.erase(std::unique(verts.begin(), verts.end()), verts.end());
  return world().sum(static_cast<std::int64_t>(verts.size()));
}

FieldSlice plain_fields(std::int64_t verts) {
  FieldSlice f = whole_fields(verts);
  f.values[1] = f.values[2] = 0;  // no extreme numbers: the ranges are compared by their difference
  f.names = {"mach", "", "velocity"};
  return f;
}

std::string all_ranges(const FieldSlice& f) {
  // Medit has the tensor as xx xy yy xz yz zz, VTK as xx yy zz xy yz xz
  return range(f, 0, "mach", 0) + range(f, 1, "field1", 0) + range(f, 2, "field1", 3) + range(f, 3, "field1", 1) +
         range(f, 4, "field1", 5) + range(f, 5, "field1", 4) + range(f, 6, "field1", 2) + range(f, 7, "velocity", 0) +
         range(f, 9, "velocity", 2);
}

TEST(Vtk, OneFile) {
  const MeshSlice whole = whole_box(3);
  const FieldSlice fields = plain_fields(whole.total_verts);
  const Folder folder(world());
  for (const bool even : {true, false}) {
    const std::string path = folder / (even ? "even.vtu" : "uneven.vtu");
    const FieldSlice mine = cut(fields, world(), even);
    write_mesh(world(), path, cut(whole, world(), even), &mine);
    expect_vtk(path, whole, whole.total_verts, all_ranges(fields));
  }
  const Comm self = Comm::self();
  if (world().is_root()) {
    write_mesh(self, folder / "one.vtu", whole, &fields);
    EXPECT_TRUE(bytes_of_file(folder / "one.vtu") == bytes_of_file(folder / "even.vtu"));
    EXPECT_TRUE(bytes_of_file(folder / "one.vtu") == bytes_of_file(folder / "uneven.vtu"));
  }
}

TEST(Vtk, Pieces) {
  const MeshSlice whole = whole_box(3);
  const FieldSlice fields = plain_fields(whole.total_verts);
  const Folder folder(world());
  for (const bool even : {true, false}) {
    const std::string path = folder / (even ? "even.pvtu" : "uneven.pvtu");
    const FieldSlice mine = cut(fields, world(), even);
    const MeshSlice slice = cut(whole, world(), even);
    write_mesh(world(), path, slice, &mine);
    expect_vtk(path, whole, piece_points(slice), all_ranges(fields));
  }
  EXPECT_EQ(folder.names().size(), 2 * (1 + static_cast<std::size_t>(world().size())));
}

TEST(Vtk, NumbersOfTheTetrahedra) {
  const MeshSlice whole = whole_box(3);
  FieldSlice all;
  all.total = whole.tets.total, all.kinds = {FieldKind::kScalar, FieldKind::kScalar}, all.width = 2;
  all.names = {"quality", "part"};
  for (std::int64_t t = 0; t < all.total; ++t)
    all.values.insert(all.values.end(), {0.5 + static_cast<double>(t), -2.0 * static_cast<double>(t)});
  const std::string ranges = range(all, 0, "cell:quality", 0) + range(all, 1, "cell:part", 0);
  const Folder folder(world());
  for (const bool even : {true, false}) {
    const MeshSlice slice = cut(whole, world(), even);
    FieldSlice mine = all;
    mine.first = slice.tets.first;
    const auto begin = all.values.begin() + 2 * slice.tets.first;
    mine.values.assign(begin, begin + 2 * std::ssize(slice.tets.verts));
    for (const std::string name : {"a.vtu", "a.pvtu"}) {
      write_mesh(world(), folder / name, slice, nullptr, GmfVersion::kLowest, &mine);
      expect_vtk(folder / name, whole, name == "a.vtu" ? whole.total_verts : piece_points(slice), ranges);
    }
  }
}

TEST(Vtk, NoFieldsAndFewerCellsThanRanks) {
  MeshSlice whole = whole_box(1);
  whole.tets.verts.resize(2);
  whole.tets.ref.resize(2);
  whole.tets.total = 2;
  whole.triangles = {};
  const Folder folder(world());
  const MeshSlice mine = cut(whole, world());
  write_mesh(world(), folder / "a.vtu", mine);
  write_mesh(world(), folder / "a.pvtu", mine);
  expect_vtk(folder / "a.vtu", whole, whole.total_verts, "");
  expect_vtk(folder / "a.pvtu", whole, piece_points(mine), "");
}

TEST(Vtk, ErrorsAreTheSameOnAllRanks) {
  const Folder folder(world());
  const MeshSlice mine = cut(whole_box(1), world());
  for (const std::string name : {"no/a.vtu", "no/a.pvtu"}) {
    const std::string path = folder / name;
    expect_contains(error_line(world(), [&] { write_mesh(world(), path, mine); }), {folder / "no"});
  }
  const FieldSlice few = cut(whole_fields(5), world());
  EXPECT_THROW(write_mesh(world(), folder / "a.vtu", mine, &few), AgreedError);
}

}  // namespace
}  // namespace skein::test
