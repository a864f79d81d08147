// skein convert: meshes and solutions from one format to another.
#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/field_transfer.hpp"
#include "app/files.hpp"
#include "app/merge_input.hpp"
#include "app/verbs.hpp"
#include "io/mesh_io.hpp"
#include "report/cell_arrays.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input, output;
  std::vector<std::string> with;  ///< solutions that go into a picture
  std::optional<double> merge;
  GmfVersion format = GmfVersion::kLowest;
  InputFiles inputs = InputFiles::kKept;
};

ExitCode convert(const Comm& comm, const Options& o) {
  std::vector<std::string> inputs = o.with;
  inputs.push_back(o.input);
  require_distinct(comm, inputs, {o.output}, o.inputs);
  const bool vtk = has_ending(o.output, {".vtu", ".pvtu"});
  agree(comm, [&] {
    if (!o.with.empty() && (!vtk || o.merge))
      throw Error(ExitCode::kUsage, "convert: --with needs an output .vtu or .pvtu, and goes without --merge");
  });
  for (const std::string& path : o.with) require_input(comm, path, kFields);
  if (has_ending(o.input, kFields)) {
    require_input(comm, o.input, kFields);
    require_output(comm, o.output, kFields);
    write_fields(comm, o.output, read_fields(comm, o.input), o.format);
    return ExitCode::kOk;
  }
  require_input(comm, o.input, {".mesh", ".meshb", ".sol", ".solb"});
  require_output(comm, o.output, kMeshOutputs);
  const auto note = [&](const std::string& line) {
    if (comm.is_root()) fmt::print("{}\n", line);
  };
  MeshSlice mesh = read_mesh_noting(comm, o.input, note);
  merge_input(comm, o.merge, mesh, nullptr, note);
  FieldSlice drawn, cells;
  if (vtk) {
    drawn = read_together(comm, mesh, o.with);
    cells = cell_arrays(comm, mesh);
  }
  write_mesh(comm, o.output, mesh, drawn.width > 0 ? &drawn : nullptr, o.format, vtk ? &cells : nullptr);
  return ExitCode::kOk;
}

}  // namespace

void add_convert(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("convert", "Convert a mesh or a solution to another format");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb) or solution (.sol, .solb)")->required();
  auto* out = verb->add_option("OUT", o->output, "mesh (.mesh, .meshb, .vtu, .pvtu) or solution (.sol, .solb)");
  auto* named = verb->add_option("-o,--output", o->output, "the same as OUT")->excludes(out);
  verb->add_option("--with", o->with, "solution at the vertices that goes into a .vtu or .pvtu; may be repeated")
      ->allow_extra_args(false);
  add_merge_option(*verb, o->merge);
  add_format_option(*verb, o->format);
  add_overwrite_option(*verb, o->inputs);
  verb->footer("Example: skein convert wing.mesh wing.vtu");
  verb->callback([o, out, named, &run] {
    if (out->empty() && named->empty()) throw CLI::RequiredError("OUT");
    run = [o](const Comm& comm) { return convert(comm, *o); };
  });
}

}  // namespace skein::app
