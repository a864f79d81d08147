// Writes .pvtu: each rank's cells with the vertices they need as a .vtu of its own, and the index of the pieces.
#include <fmt/format.h>

#include <algorithm>

#include "comm/exchange.hpp"
#include "comm/file.hpp"
#include "io/formats.hpp"

namespace skein::io {
namespace {

struct Piece {
  MeshSlice mesh;
  FieldSlice fields;
};

template <std::size_t N>
void collect_verts(const EntitySlice<N>& s, std::vector<GlobalId>& out) {
  for (const auto& v : s.verts) out.insert(out.end(), v.begin(), v.end());
}

/// This rank's cells with vertices numbered by their place in `verts` (ascending).
template <std::size_t N>
EntitySlice<N> local_cells(const EntitySlice<N>& s, const std::vector<GlobalId>& verts) {
  EntitySlice<N> out{static_cast<std::int64_t>(s.verts.size()), 0, s.verts, s.ref};
  for (auto& cell : out.verts) {
    for (GlobalId& v : cell) v = to_id<GlobalId>(std::ranges::lower_bound(verts, v) - verts.begin());
  }
  return out;
}

/// Collective. Asks the ranks that hold the vertices for their coordinates and fields.
void fetch_verts(const Comm& comm, const MeshSlice& mesh, const FieldSlice* fields, const std::vector<GlobalId>& verts,
                 Piece& piece) {
  const std::vector<std::int64_t> first = comm.all_gather(mesh.first_vert);
  std::vector<Rank> dest(verts.size());
  for (std::size_t i = 0; i < verts.size(); ++i) {
    dest[i] = to_id<Rank>(std::ranges::upper_bound(first, num(verts[i])) - first.begin() - 1);
  }
  const Packets<GlobalId> sent = pack<GlobalId>(dest, verts);
  const Packets<GlobalId> asked = exchange(comm, sent);
  const auto here = [&](std::size_t i) { return static_cast<std::size_t>(num(asked.items[i]) - mesh.first_vert); };
  std::vector<Vec3> coords(asked.items.size());
  for (std::size_t i = 0; i < coords.size(); ++i) coords[i] = mesh.coords[here(i)];
  piece.mesh.coords = reply<GlobalId, Vec3>(comm, sent, asked, coords);
  if (fields == nullptr) return;
  const auto width = static_cast<std::size_t>(fields->width);
  piece.fields.values.resize(verts.size() * width);
  for (std::size_t k = 0; k < width; ++k) {
    std::vector<double> column(asked.items.size());
    for (std::size_t i = 0; i < column.size(); ++i) column[i] = fields->values[here(i) * width + k];
    const std::vector<double> got = reply<GlobalId, double>(comm, sent, asked, column);
    for (std::size_t i = 0; i < got.size(); ++i) piece.fields.values[i * width + k] = got[i];
  }
}

Piece make_piece(const Comm& comm, const MeshSlice& mesh, const FieldSlice* fields) {
  Piece p;
  std::vector<GlobalId> verts;
  collect_verts(mesh.tets, verts);
  collect_verts(mesh.triangles, verts);
  std::ranges::sort(verts);
  verts.erase(std::unique(verts.begin(), verts.end()), verts.end());
  p.mesh.tets = local_cells(mesh.tets, verts);
  p.mesh.triangles = local_cells(mesh.triangles, verts);
  p.mesh.total_verts = static_cast<std::int64_t>(verts.size());
  fetch_verts(comm, mesh, fields, verts, p);
  if (fields != nullptr) {
    p.fields.kinds = fields->kinds;
    p.fields.names = fields->names;
    p.fields.width = fields->width;
    p.fields.total = p.mesh.total_verts;
  }
  return p;
}

std::string piece_path(const std::string& path, int rank) {
  return fmt::format("{}_{}.vtu", path.substr(0, path.rfind('.')), rank);
}

std::string index_text(const std::string& path, int ranks, const FieldSlice* fields, const FieldSlice* on_tets) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">\n<PPointData>\n";
  for (std::size_t i = 0; fields != nullptr && i < fields->kinds.size(); ++i) {
    xml += fmt::format("<PDataArray {}/>\n", vtk_field_attributes(*fields, i));
  }
  xml += "</PPointData>\n<PCellData>\n<PDataArray type=\"Int32\" Name=\"ref\"/>\n";
  for (std::size_t i = 0; on_tets != nullptr && i < on_tets->kinds.size(); ++i) {
    xml += fmt::format("<PDataArray {}/>\n", vtk_field_attributes(*on_tets, i));
  }
  xml +=
      "</PCellData>\n<PPoints>\n"
      "<PDataArray type=\"Float64\" Name=\"points\" NumberOfComponents=\"3\"/>\n</PPoints>\n";
  for (int r = 0; r < ranks; ++r) {
    const std::string piece = piece_path(path, r);
    xml += fmt::format("<Piece Source=\"{}\"/>\n", xml_escaped(piece.substr(piece.rfind('/') + 1)));
  }
  return xml + "</PUnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace

void write_pvtu(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields,
                const FieldSlice* on_tets) {
  const Piece piece = make_piece(comm, mesh, fields);
  agree(comm, [&] {
    const Comm self = Comm::self();
    write_vtu(self, piece_path(path, num(comm.rank())), piece.mesh, fields == nullptr ? nullptr : &piece.fields,
              on_tets);
  });
  agree(comm, [&] {
    if (!comm.is_root()) return;
    const Comm self = Comm::self();
    OutputFile out(self, path);
    const std::string text = index_text(path, comm.size(), fields, on_tets);
    out.write(0, std::as_bytes(std::span(text.data(), text.size())));
    out.commit();
  });
}

}  // namespace skein::io
