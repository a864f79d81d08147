// The sample mesh and the helpers of the io tests.
#include "tests/io/sample.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "comm/file.hpp"
#include "io/keywords.hpp"
#include "tests/support/whole_mesh.hpp"

namespace skein::test {
namespace {

namespace fs = std::filesystem;

void add_hull(MeshSlice& m) {
  using Face = std::array<GlobalId, 3>;
  std::vector<std::pair<Face, Face>> faces;  // sorted vertices, vertices
  for (const auto& t : m.tets.verts) {
    for (const auto& f : kFaceVerts) {
      const Face face{t[f[0]], t[f[1]], t[f[2]]};
      Face key = face;
      std::ranges::sort(key);
      faces.emplace_back(key, face);
    }
  }
  std::ranges::sort(faces);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool twice = (i > 0 && faces[i - 1].first == faces[i].first) ||
                       (i + 1 < faces.size() && faces[i + 1].first == faces[i].first);
    if (twice) continue;
    m.triangles.verts.push_back(faces[i].second);
    m.triangles.ref.push_back(static_cast<std::int32_t>(i % 3) + 1);
  }
}

template <class S>
void set_total(S& s) {
  s.total = static_cast<std::int64_t>(s.verts.size());
}

/// Rank 1 gets nothing, the last one half of all.
Slice share(std::int64_t n, const Comm& comm, bool even) {
  if (even) return even_slice(n, comm.rank(), comm.size());
  std::vector<std::int64_t> end{0};
  for (int r = 0; r < comm.size(); ++r) {
    const bool last = r + 1 == comm.size();
    end.push_back(last ? n : end.back() + (r == 1 ? 0 : (n / 2 - end.back()) / 2));
  }
  return {end[idx(comm.rank())], end[idx(comm.rank()) + 1]};
}

template <class T>
std::vector<T> part(const std::vector<T>& v, Slice s, std::size_t width = 1) {
  const auto at = [&](std::int64_t i) { return v.begin() + i * static_cast<std::int64_t>(width); };
  return {at(s.first), at(s.last)};
}

template <std::size_t N>
void cut_refs(EntitySlice<N>& s, const EntitySlice<N>& whole, Slice range) {
  s.ref = part(whole.ref, range);
}
void cut_refs(VertexListSlice&, const VertexListSlice&, Slice) {}
template <std::size_t N>
void join_refs(const Comm& comm, EntitySlice<N>& s) {
  s.ref = comm.all_gather(s.ref);
}
void join_refs(const Comm&, VertexListSlice&) {}
template <std::size_t N>
void expect_same_refs(const EntitySlice<N>& a, const EntitySlice<N>& b) {
  EXPECT_EQ(a.ref, b.ref);
}
void expect_same_refs(const VertexListSlice&, const VertexListSlice&) {}

/// Calls f for the sections of two meshes side by side.
template <class F>
void for_both(MeshSlice& a, const MeshSlice& b, F&& f) {
  f(a.edges, b.edges);
  f(a.triangles, b.triangles);
  f(a.tets, b.tets);
  f(a.corners, b.corners);
  f(a.ridges, b.ridges);
  f(a.required_verts, b.required_verts);
  f(a.required_edges, b.required_edges);
  f(a.required_triangles, b.required_triangles);
}

void expect_place(const Comm& comm, std::int64_t first, std::int64_t size, std::int64_t total, bool even) {
  EXPECT_EQ(first, comm.exclusive_sum(size));
  EXPECT_EQ(total, comm.sum(size));
  if (!even) return;
  EXPECT_EQ(size, even_slice(total, comm.rank(), comm.size()).size());
}

}  // namespace

MeshSlice whole_box(int n) {
  MeshSlice m;
  const Lattice lattice{n};
  const WholeMesh box = cells(n);
  for (std::size_t v = 0; v < box.coords.size(); ++v) {
    const Vec3 x = box.coords[v];
    const auto [i, j, k] = lattice.place(static_cast<std::int64_t>(v));
    m.coords.push_back({x.x / 3 - 1e-17, std::exp(x.y), 1e-30 + x.z * 7e5 / 11});
    m.vert_ref.push_back(i * j - k);
  }
  for (const auto& t : box.tets) {
    m.tets.ref.push_back(static_cast<std::int32_t>(m.tets.verts.size() % 5) - 2);
    m.tets.verts.push_back({GlobalId{t[0]}, GlobalId{t[1]}, GlobalId{t[2]}, GlobalId{t[3]}});
  }
  add_hull(m);
  const auto vert = [&](int i, int j, int k) { return GlobalId{lattice.number(i, j, k)}; };
  for (int i = 0; i < n; ++i) {
    m.edges.verts.push_back({vert(i, 0, 0), vert(i + 1, 0, 0)});
    m.edges.ref.push_back(-i);
  }
  m.corners.verts = {GlobalId{0}, GlobalId{n}, vert(n, n, n)};
  m.ridges.verts = {GlobalId{n - 1}, GlobalId{0}};
  m.required_verts.verts = {vert(n, n, 0)};
  m.required_edges.verts = {GlobalId{0}};
  m.required_triangles.verts = {GlobalId{1}, GlobalId{3}, GlobalId{2}};
  m.total_verts = static_cast<std::int64_t>(m.coords.size());
  for_both(m, m, [](auto& s, const auto&) { set_total(s); });
  return m;
}

FieldSlice whole_fields(std::int64_t verts) {
  FieldSlice f;
  f.total = verts;
  f.kinds = {FieldKind::kScalar, FieldKind::kTensor, FieldKind::kVector};
  f.width = 10;
  for (std::int64_t i = 0; i < verts * f.width; ++i) {
    const auto x = static_cast<double>(i);
    f.values.push_back(std::sin(x) * std::pow(10.0, static_cast<double>(i % 40 - 20)));
  }
  f.values[0] = -0.0;
  f.values[1] = 5e-324;
  f.values[2] = 1.7976931348623157e308;
  return f;
}

double volume(const MeshSlice& whole) {
  double sum = 0;
  for (const auto& t : whole.tets.verts) {
    sum += volume6(whole.coords[idx(t[0])], whole.coords[idx(t[1])], whole.coords[idx(t[2])], whole.coords[idx(t[3])]);
  }
  return sum / 6;
}

MeshSlice cut(const MeshSlice& whole, const Comm& comm, bool even) {
  MeshSlice m = whole;
  const Slice v = share(whole.total_verts, comm, even);
  m.first_vert = v.first;
  m.coords = part(whole.coords, v);
  m.vert_ref = part(whole.vert_ref, v);
  for_both(m, whole, [&](auto& s, const auto& w) {
    const Slice range = share(w.total, comm, even);
    s.first = range.first;
    s.verts = part(w.verts, range);
    cut_refs(s, w, range);
  });
  return m;
}

FieldSlice cut(const FieldSlice& whole, const Comm& comm, bool even) {
  FieldSlice f = whole;
  const Slice range = share(whole.total, comm, even);
  f.first = range.first;
  f.values = part(whole.values, range, static_cast<std::size_t>(whole.width));
  return f;
}

MeshSlice join(const Comm& comm, const MeshSlice& mine, bool even) {
  MeshSlice m = mine;
  expect_place(comm, mine.first_vert, static_cast<std::int64_t>(mine.coords.size()), mine.total_verts, even);
  m.first_vert = 0;
  m.coords = comm.all_gather(mine.coords);
  m.vert_ref = comm.all_gather(mine.vert_ref);
  for_both(m, mine, [&](auto& s, const auto& part_of) {
    expect_place(comm, part_of.first, static_cast<std::int64_t>(part_of.verts.size()), part_of.total, even);
    s.first = 0;
    s.verts = comm.all_gather(part_of.verts);
    join_refs(comm, s);
  });
  return m;
}

FieldSlice join(const Comm& comm, const FieldSlice& mine, bool even) {
  FieldSlice f = mine;
  expect_place(comm, mine.first, static_cast<std::int64_t>(mine.values.size()) / mine.width, mine.total, even);
  f.first = 0;
  f.values = comm.all_gather(mine.values);
  return f;
}

void expect_same(const MeshSlice& a, const MeshSlice& b) {
  EXPECT_EQ(a.total_verts, b.total_verts);
  EXPECT_EQ(a.vert_ref, b.vert_ref);
  const bool same = a.coords.size() == b.coords.size() &&
                    (a.coords.empty() || std::memcmp(a.coords.data(), b.coords.data(), a.coords.size() * 24) == 0);
  EXPECT_TRUE(same) << "coordinates differ";
  MeshSlice copy = a;
  for_both(copy, b, [](const auto& x, const auto& y) {
    EXPECT_EQ(x.total, y.total);
    EXPECT_TRUE(x.verts == y.verts);
    expect_same_refs(x, y);
  });
}

void expect_same(const FieldSlice& a, const FieldSlice& b) {
  EXPECT_EQ(a.total, b.total);
  EXPECT_EQ(a.width, b.width);
  EXPECT_TRUE(a.kinds == b.kinds);
  const bool same = a.values.size() == b.values.size() &&
                    (a.values.empty() || std::memcmp(a.values.data(), b.values.data(), a.values.size() * 8) == 0);
  EXPECT_TRUE(same) << "values differ";
}

Folder::Folder(const Comm& comm) : comm_(comm) {
  std::string path = (fs::temp_directory_path() / "skein-io-XXXXXX").string();
  if (comm.is_root() && ::mkdtemp(path.data()) == nullptr) path.clear();
  path_ = comm.broadcast(path);
}

Folder::~Folder() {
  comm_.barrier();
  std::error_code e;
  if (comm_.is_root()) fs::remove_all(path_, e);
}

std::string Folder::write(const std::string& name, const std::vector<std::byte>& bytes) const {
  std::string path = *this / name;
  comm_.barrier();
  if (comm_.is_root()) {
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  comm_.barrier();
  return path;
}

std::string Folder::write(const std::string& name, const std::string& text) const {
  std::vector<std::byte> bytes(text.size());
  std::ranges::transform(text, bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return write(name, bytes);
}

std::vector<std::string> Folder::names() const {
  std::vector<std::string> out;
  comm_.barrier();
  for (const auto& entry : fs::directory_iterator(path_)) out.push_back(entry.path().filename().string());
  comm_.barrier();
  std::ranges::sort(out);
  return out;
}

std::vector<std::byte> bytes_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::vector<std::byte> out(text.size());
  std::ranges::transform(text, out.begin(), [](char c) { return static_cast<std::byte>(c); });
  return out;
}

std::string error_or_success(const Comm& comm, const std::function<void()>& f) {
  std::string line;
  try {
    f();
  } catch (const AgreedError& e) {
    line = e.what();
    EXPECT_NE(e.code(), ExitCode::kInternal) << line;
  }
  EXPECT_EQ(line, comm.broadcast(line)) << "the ranks disagree";
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  return line;
}

std::string error_line(const Comm& comm, const std::function<void()>& f) {
  std::string line = error_or_success(comm, f);
  EXPECT_FALSE(line.empty()) << "no error was thrown";
  return line;
}

void expect_contains(const std::string& line, const std::vector<std::string>& parts) {
  for (const std::string& p : parts) EXPECT_NE(line.find(p), std::string::npos) << "'" << p << "' is not in: " << line;
}

}  // namespace skein::test
