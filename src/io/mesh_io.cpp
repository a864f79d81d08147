// Which format a path asks for.
#include "io/mesh_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "comm/file.hpp"
#include "io/formats.hpp"
#include "io/keywords.hpp"

namespace skein {
namespace {

bool is(const std::string& path, std::string_view ending) { return path.ends_with(ending); }

/// Collective. Throws on all ranks.
void refuse_ending(const Comm& comm, ExitCode code, const std::string& path, std::string_view known) {
  agree(comm, [&] {
    throw Error(code, fmt::format("{}: the file extension says the format, and this is none of {}", path, known));
  });
}

/// The slices must lie in rank order without gaps; a caller that breaks this would write a scrambled file.
void require_slices(const Comm& comm, const std::string& path, std::int64_t first, std::int64_t size,
                    std::int64_t total) {
  const std::int64_t before = comm.exclusive_sum(size);
  const std::int64_t all = comm.sum(size);
  agree(comm, [&] {
    if (first == before && total == all) return;
    throw Error(ExitCode::kInternal,
                fmt::format("{}: the slice given by rank {} begins at {} of {}, but the ranks before hold {} of {}: "
                            "report this as a bug",
                            path, num(comm.rank()), first, total, before, all));
  });
}

void require_fields(const Comm& comm, const std::string& path, const FieldSlice& fields) {
  agree(comm, [&] {
    int width = 0;
    for (const FieldKind k : fields.kinds) width += components(k);
    const bool whole = width > 0 && fields.values.size() % static_cast<std::size_t>(width) == 0;
    if (width == fields.width && whole && static_cast<std::int64_t>(fields.kinds.size()) <= io::kMaxFields) return;
    throw Error(ExitCode::kInternal,
                fmt::format("{}: fields to write do not fit their kinds: report this as a bug", path));
  });
  require_slices(comm, path, fields.first, static_cast<std::int64_t>(fields.values.size()) / fields.width,
                 fields.total);
}

/// Fields beside a mesh are cut as its vertices are.
void require_same_verts(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice& fields) {
  require_fields(comm, path, fields);
  agree(comm, [&] {
    if (fields.total == mesh.total_verts && fields.first == mesh.first_vert) return;
    throw Error(ExitCode::kInternal,
                fmt::format("{}: fields for {} vertices (from {} on rank {}), but the mesh has {} "
                            "(from {}): report this as a bug",
                            path, fields.total, fields.first, num(comm.rank()), mesh.total_verts, mesh.first_vert));
  });
}

void require_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh) {
  require_slices(comm, path, mesh.first_vert, static_cast<std::int64_t>(mesh.coords.size()), mesh.total_verts);
  io::for_each_section(mesh, [&](const io::RecordSpec&, const auto& s) {
    require_slices(comm, path, s.first, static_cast<std::int64_t>(s.verts.size()), s.total);
  });
}

}  // namespace

MeshSlice read_mesh(const Comm& comm, const std::string& path) {
  if (is(path, ".meshb")) return io::read_gmf_mesh(comm, path);
  if (is(path, ".mesh")) return io::read_medit_mesh(comm, path);
  refuse_ending(comm, ExitCode::kInput, path, ".mesh, .meshb");
  return {};
}

FieldSlice read_fields(const Comm& comm, const std::string& path) {
  if (is(path, ".solb")) return io::read_gmf_fields(comm, path);
  if (is(path, ".sol")) return io::read_medit_fields(comm, path);
  refuse_ending(comm, ExitCode::kInput, path, ".sol, .solb");
  return {};
}

void write_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields,
                GmfVersion version, const FieldSlice* on_tets) {
  require_mesh(comm, path, mesh);
  const bool vtk = is(path, ".vtu") || is(path, ".pvtu");
  if (vtk && fields != nullptr) require_same_verts(comm, path, mesh, *fields);
  if (is(path, ".meshb")) return io::write_gmf_mesh(comm, path, mesh, version);
  if (is(path, ".mesh")) return io::write_medit_mesh(comm, path, mesh);
  if (is(path, ".vtu")) return io::write_vtu(comm, path, mesh, fields, on_tets);
  if (is(path, ".pvtu")) return io::write_pvtu(comm, path, mesh, fields, on_tets);
  refuse_ending(comm, ExitCode::kOutput, path, ".mesh, .meshb, .vtu, .pvtu");
}

void write_fields(const Comm& comm, const std::string& path, const FieldSlice& fields, GmfVersion version) {
  require_fields(comm, path, fields);
  if (is(path, ".solb")) return io::write_gmf_fields(comm, path, fields, version);
  if (is(path, ".sol")) return io::write_medit_fields(comm, path, fields);
  refuse_ending(comm, ExitCode::kOutput, path, ".sol, .solb");
}

void require_output(const Comm& comm, const std::string& path) {
  constexpr std::array kEndings{".mesh", ".meshb", ".vtu", ".pvtu", ".sol", ".solb"};
  const bool known = std::ranges::any_of(kEndings, [&](const char* e) { return is(path, e); });
  if (!known) refuse_ending(comm, ExitCode::kOutput, path, ".mesh, .meshb, .vtu, .pvtu, .sol, .solb");
  const OutputFile trial(comm, path);  // not committed: removed again
}

}  // namespace skein
