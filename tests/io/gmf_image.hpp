// A GMF binary file put together by hand, number by number, in any version and byte order.
#pragma once
#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "mesh/mesh_slice.hpp"

namespace skein::test {

class GmfImage {
 public:
  explicit GmfImage(int version, bool swap = false) : version_(version), swap_(swap) {
    i32(1);
    i32(version);
  }
  void dimension(std::int32_t d) {
    head(3);
    i32(d);
    finish();
  }
  void i32(std::int32_t v) { put(v); }
  void i64(std::int64_t v) { put(v); }
  void integer(std::int64_t v) { version_ >= 4 ? put(v) : put(static_cast<std::int32_t>(v)); }
  void real(double v) { version_ == 1 ? put(static_cast<float>(v)) : put(v); }
  /// Begins a section; finish() fills in where the next one begins.
  void head(std::int32_t keyword) {
    i32(keyword);
    position_ = bytes.size();
    version_ >= 3 ? i64(0) : i32(0);
  }
  void head(std::int32_t keyword, std::int64_t count) {
    head(keyword);
    integer(count);
  }
  void finish() {
    const auto next = static_cast<std::int64_t>(bytes.size());
    if (version_ >= 3) {
      store(position_, next);
    } else {
      store(position_, static_cast<std::int32_t>(next));
    }
  }
  void end() {
    i32(54);
    version_ >= 3 ? i64(0) : i32(0);
  }
  template <class T>
  void store(std::size_t at, T v) {
    std::byte b[sizeof v];
    std::memcpy(b, &v, sizeof v);
    if (swap_) std::reverse(b, b + sizeof v);
    std::copy(b, b + sizeof v, bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }

  template <std::size_t N>
  void cells(std::int32_t keyword, const EntitySlice<N>& s) {
    head(keyword, s.total);
    for (std::size_t i = 0; i < s.verts.size(); ++i) {
      for (const GlobalId v : s.verts[i]) integer(num(v) + 1);
      integer(s.ref[i]);
    }
    finish();
  }
  void list(std::int32_t keyword, const VertexListSlice& s) {
    head(keyword, s.total);
    for (const GlobalId v : s.verts) integer(num(v) + 1);
    finish();
  }
  void vertices(const MeshSlice& m) {
    head(4, m.total_verts);
    for (std::size_t i = 0; i < m.coords.size(); ++i) {
      real(m.coords[i].x);
      real(m.coords[i].y);
      real(m.coords[i].z);
      integer(m.vert_ref[i]);
    }
    finish();
  }
  /// All sections of `whole`, with some in between that a reader passes over.
  void mesh(const MeshSlice& whole) {
    dimension(3);
    cells(8, whole.tets);  // before the vertices: any order is allowed
    skipped();
    vertices(whole);
    list(14, whole.ridges);
    cells(5, whole.edges);
    cells(6, whole.triangles);
    list(13, whole.corners);
    list(15, whole.required_verts);
    list(16, whole.required_edges);
    list(17, whole.required_triangles);
    head(7, 0);  // no quadrilaterals: fine
    finish();
    end();
  }
  /// Vertices on geometry and a flow of bytes.
  void skipped() {
    head(40, 1);
    integer(1);
    integer(2);
    finish();
    head(126, 5);
    for (const char c : {'a', 'b', 'c', 'd', 'e'}) bytes.push_back(static_cast<std::byte>(c));
    finish();
  }

  std::vector<std::byte> bytes;

 private:
  template <class T>
  void put(T v) {
    bytes.resize(bytes.size() + sizeof v);
    store(bytes.size() - sizeof v, v);
  }
  int version_;
  bool swap_;
  std::size_t position_ = 0;
};

}  // namespace skein::test
