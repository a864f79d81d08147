// The fields that travel with the mesh.
#include "app/field_transfer.hpp"

#include <fmt/core.h>

#include <utility>

#include "api/adaptation.hpp"
#include "app/files.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

/// "mach" for some/mach.solb, "state_2" for the second of several fields in it.
std::string field_name(const std::string& path, std::size_t i, std::size_t n) {
  std::string stem = path.substr(path.find_last_of('/') + 1);
  stem = stem.substr(0, stem.find_last_of('.'));
  return n == 1 ? stem : fmt::format("{}_{}", stem, i + 1);
}

}  // namespace

void add_field_options(CLI::App& verb, FieldOptions& o) {
  verb.add_option("--field-in", o.in, "solution of any fields to be carried to the new mesh; may be repeated")
      ->allow_extra_args(false);
  verb.add_option("--field-out", o.out, "these fields at the vertices of the new mesh (.sol, .solb)");
}

void require_fields(const Comm& comm, const FieldOptions& o, const std::string& output) {
  agree(comm, [&] {
    if (o.in.empty() && !o.out.empty()) {
      throw Error(ExitCode::kUsage, "adapt: --field-out needs --field-in, the fields that shall be carried over");
    }
    if (!o.in.empty() && o.out.empty() && !has_ending(output, {".vtu", ".pvtu"})) {
      throw Error(ExitCode::kUsage, "adapt: --field-in needs --field-out, the solution file to write");
    }
  });
  for (const auto& path : o.in) require_input(comm, path, kFields);
  require_output(comm, o.out, kFields);
}

FieldSlice read_together(const Comm& comm, const MeshSlice& mesh, const std::vector<std::string>& paths) {
  FieldSlice all;
  all.total = mesh.total_verts, all.first = mesh.first_vert;
  FieldOptions o;
  o.in = paths;
  all.names = read_fields_behind(comm, mesh, o, all).names;
  return all;
}

FieldsOut read_fields_behind(const Comm& comm, const MeshSlice& mesh, const FieldOptions& o, FieldSlice& values) {
  FieldsOut out;
  out.path = o.out;
  for (const auto& path : o.in) {
    const FieldSlice f = read_fields(comm, path);
    agree(comm, [&] {
      if (f.total != mesh.total_verts) {
        throw Error(ExitCode::kInput, fmt::format("{}: {} values for the {} vertices of {}; give the one of this mesh",
                                                  path, f.total, mesh.total_verts, mesh.path));
      }
      values = side_by_side(std::move(values), f);
      for (std::size_t i = 0; i < f.kinds.size(); ++i) {
        out.kinds.push_back(f.kinds[i]);
        out.names.push_back(field_name(path, i, f.kinds.size()));
      }
    });
  }
  return out;
}

}  // namespace skein::app
