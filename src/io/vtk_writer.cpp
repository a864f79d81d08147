// Writes VTK XML unstructured grids (.vtu) with raw appended data: the places of all arrays follow from the totals.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "comm/file.hpp"
#include "io/formats.hpp"

namespace skein::io {
namespace {

constexpr std::size_t kChunkItems = std::size_t{1} << 16;
constexpr std::uint8_t kVtkTriangle = 5, kVtkTetra = 10;
// Medit has m11 m12 m22 m13 m23 m33, VTK has XX YY ZZ XY YZ XZ
constexpr std::array<std::size_t, 6> kVtkTensor{0, 2, 5, 1, 4, 3};

/// The array's place behind the underscore that begins the data, and the XML line that tells it.
class Arrays {
 public:
  /// Returns where the array begins; its byte count stands in 8 bytes before the values.
  std::int64_t add(const std::string& attributes, std::int64_t bytes) {
    xml_ += fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"/>\n", attributes, size_);
    begin_.push_back(size_);
    bytes_.push_back(bytes);
    size_ += 8 + bytes;
    return begin_.back();
  }
  void text(const std::string& xml) { xml_ += xml; }
  [[nodiscard]] const std::string& xml() const noexcept { return xml_; }
  [[nodiscard]] std::int64_t size() const noexcept { return size_; }
  [[nodiscard]] const std::vector<std::int64_t>& begin() const noexcept { return begin_; }
  [[nodiscard]] const std::vector<std::int64_t>& bytes() const noexcept { return bytes_; }

 private:
  std::string xml_;
  std::int64_t size_ = 0;
  std::vector<std::int64_t> begin_, bytes_;
};

/// Where each array is; the same on every rank.
struct Layout {
  Arrays arrays;
  std::vector<std::int64_t> field, cell;
  std::int64_t ref = 0, points = 0, connectivity = 0, offsets = 0, types = 0;
};

Layout make_layout(const MeshSlice& mesh, const FieldSlice* fields, const FieldSlice* on_tets) {
  Layout l;
  Arrays& a = l.arrays;
  const std::int64_t verts = mesh.total_verts, tets = mesh.tets.total, triangles = mesh.triangles.total;
  const std::int64_t cells = tets + triangles;
  a.text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n");
  a.text(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>\n", verts, cells));
  for (std::size_t i = 0; fields != nullptr && i < fields->kinds.size(); ++i) {
    l.field.push_back(a.add(vtk_field_attributes(*fields, i), verts * 8 * components(fields->kinds[i])));
  }
  a.text("</PointData>\n<CellData>\n");
  l.ref = a.add("type=\"Int32\" Name=\"ref\"", cells * 4);
  for (std::size_t i = 0; on_tets != nullptr && i < on_tets->kinds.size(); ++i) {
    l.cell.push_back(a.add(vtk_field_attributes(*on_tets, i), cells * 8));
  }
  a.text("</CellData>\n<Points>\n");
  l.points = a.add("type=\"Float64\" Name=\"points\" NumberOfComponents=\"3\"", verts * 24);
  a.text("</Points>\n<Cells>\n");
  l.connectivity = a.add("type=\"Int64\" Name=\"connectivity\"", (4 * tets + 3 * triangles) * 8);
  l.offsets = a.add("type=\"Int64\" Name=\"offsets\"", cells * 8);
  l.types = a.add("type=\"UInt8\" Name=\"types\"", cells);
  a.text("</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
  return l;
}

/// Writes this rank's values into the arrays. Not collective.
class Writer {
 public:
  Writer(OutputFile& out, const Layout& layout)
      : out_(out), data_(static_cast<std::int64_t>(layout.arrays.xml().size())) {}

  /// Items first .. first + n of `width` values each; fill(i, values) gives one.
  template <class T, class F>
  void array(std::int64_t begin, std::int64_t first, std::size_t n, std::size_t width, F&& fill) {
    std::vector<T> buffer(std::min(kChunkItems, n) * width);
    for (std::size_t i = 0; i < n; i += kChunkItems) {
      const std::size_t m = std::min(kChunkItems, n - i);
      for (std::size_t k = 0; k < m; ++k) fill(i + k, buffer.data() + k * width);
      const std::int64_t item = (first + static_cast<std::int64_t>(i)) * static_cast<std::int64_t>(width);
      bytes(begin + 8 + item * static_cast<std::int64_t>(sizeof(T)), std::as_bytes(std::span(buffer).first(m * width)));
    }
  }
  void frame(const Layout& l) {
    out_.write(0, std::as_bytes(std::span(l.arrays.xml().data(), l.arrays.xml().size())));
    for (std::size_t i = 0; i < l.arrays.begin().size(); ++i) {
      bytes(l.arrays.begin()[i], std::as_bytes(std::span(&l.arrays.bytes()[i], 1)));
    }
    constexpr std::string_view kTail = "\n</AppendedData>\n</VTKFile>\n";
    bytes(l.arrays.size(), std::as_bytes(std::span(kTail)));
  }

 private:
  void bytes(std::int64_t at, std::span<const std::byte> b) { out_.write(data_ + at, b); }
  OutputFile& out_;
  const std::int64_t data_;
};

/// The cells of one kind; before: cells and vertex numbers of the kinds in front of it.
template <std::size_t N>
void write_cells(Writer& w, const Layout& l, const EntitySlice<N>& s, std::uint8_t type, std::int64_t cells_before,
                 std::int64_t numbers_before) {
  const std::size_t n = s.verts.size();
  const std::int64_t first = cells_before + s.first;
  w.array<std::int32_t>(l.ref, first, n, 1, [&](std::size_t i, std::int32_t* v) { *v = s.ref[i]; });
  w.array<std::int64_t>(l.connectivity + numbers_before * 8, s.first, n, N, [&](std::size_t i, std::int64_t* v) {
    for (std::size_t k = 0; k < N; ++k) v[k] = num(s.verts[i][k]);
  });
  w.array<std::int64_t>(l.offsets, first, n, 1, [&](std::size_t i, std::int64_t* v) {
    *v = numbers_before + (s.first + static_cast<std::int64_t>(i) + 1) * static_cast<std::int64_t>(N);
  });
  w.array<std::uint8_t>(l.types, first, n, 1, [&](std::size_t, std::uint8_t* v) { *v = type; });
}

void write_field_arrays(Writer& w, const Layout& l, const FieldSlice& fields) {
  const auto stride = static_cast<std::size_t>(fields.width);
  const std::size_t n = fields.values.size() / stride;
  std::size_t column = 0;
  for (std::size_t f = 0; f < fields.kinds.size(); ++f) {
    const auto width = static_cast<std::size_t>(components(fields.kinds[f]));
    w.array<double>(l.field[f], fields.first, n, width, [&](std::size_t i, double* v) {
      const double* from = fields.values.data() + i * stride + column;
      for (std::size_t k = 0; k < width; ++k) v[k] = from[width == 6 ? kVtkTensor[k] : k];
    });
    column += width;
  }
}

/// Numbers of the tetrahedra, and none (NaN) of the triangles.
void write_tet_arrays(Writer& w, const Layout& l, const MeshSlice& mesh, const FieldSlice& on_tets) {
  const auto width = static_cast<std::size_t>(on_tets.width);
  for (std::size_t f = 0; f < width; ++f) {
    w.array<double>(l.cell[f], mesh.tets.first, mesh.tets.verts.size(), 1,
                    [&](std::size_t i, double* v) { *v = on_tets.values[i * width + f]; });
    w.array<double>(l.cell[f], mesh.tets.total + mesh.triangles.first, mesh.triangles.verts.size(), 1,
                    [&](std::size_t, double* v) { *v = std::numeric_limits<double>::quiet_NaN(); });
  }
}

}  // namespace

std::string xml_escaped(const std::string& s) {
  std::string out;
  for (const char c : s) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string vtk_field_attributes(const FieldSlice& fields, std::size_t i) {
  const std::string name =
      i < fields.names.size() && !fields.names[i].empty() ? xml_escaped(fields.names[i]) : fmt::format("field{}", i);
  const int width = components(fields.kinds[i]);
  std::string out = fmt::format("type=\"Float64\" Name=\"{}\" NumberOfComponents=\"{}\"", name, width);
  constexpr std::array<const char*, 6> kNames{"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
  for (std::size_t k = 0; width == 6 && k < 6; ++k) out += fmt::format(" ComponentName{}=\"{}\"", k, kNames[k]);
  return out;
}

void write_vtu(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields,
               const FieldSlice* on_tets) {
  const Layout l = make_layout(mesh, fields, on_tets);
  OutputFile out(comm, path);
  agree(comm, [&] {
    Writer w(out, l);
    if (comm.is_root()) w.frame(l);
    w.array<double>(l.points, mesh.first_vert, mesh.coords.size(), 3, [&](std::size_t i, double* v) {
      v[0] = mesh.coords[i].x;
      v[1] = mesh.coords[i].y;
      v[2] = mesh.coords[i].z;
    });
    write_cells(w, l, mesh.tets, kVtkTetra, 0, 0);
    write_cells(w, l, mesh.triangles, kVtkTriangle, mesh.tets.total, 4 * mesh.tets.total);
    if (fields != nullptr) write_field_arrays(w, l, *fields);
    if (on_tets != nullptr) write_tet_arrays(w, l, mesh, *on_tets);
  });
  out.commit();
}

}  // namespace skein::io
