// skein convert: meshes and solutions from one format to another.
#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string>

#include "app/files.hpp"
#include "app/merge_input.hpp"
#include "app/verbs.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input, output;
  std::optional<double> merge;
  GmfVersion format = GmfVersion::kLowest;
};

ExitCode convert(const Comm& comm, const Options& o) {
  if (has_ending(o.input, kFields)) {
    require_input(comm, o.input, kFields);
    require_output(comm, o.output, kFields);
    write_fields(comm, o.output, read_fields(comm, o.input), o.format);
    return ExitCode::kOk;
  }
  require_input(comm, o.input, {".mesh", ".meshb", ".sol", ".solb"});
  require_output(comm, o.output, kMeshOutputs);
  MeshSlice mesh = read_mesh(comm, o.input);
  merge_input(comm, o.merge, mesh, nullptr, [&](const std::string& line) {
    if (comm.is_root()) fmt::print("{}\n", line);
  });
  write_mesh(comm, o.output, mesh, nullptr, o.format);
  return ExitCode::kOk;
}

}  // namespace

void add_convert(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("convert", "Convert a mesh or a solution to another format");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb) or solution (.sol, .solb)")->required();
  verb->add_option("OUT", o->output, "mesh (.mesh, .meshb, .vtu, .pvtu) or solution (.sol, .solb)")->required();
  add_merge_option(*verb, o->merge);
  add_format_option(*verb, o->format);
  verb->footer("Example: skein convert wing.mesh wing.vtu");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return convert(comm, *o); }; });
}

}  // namespace skein::app
