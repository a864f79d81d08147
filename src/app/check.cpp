// skein check: is a mesh file valid, and if not, where?
#include "report/check.hpp"

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
  std::string input;
  bool json = false;
  std::optional<double> merge;
};

ExitCode check(const Comm& comm, const Options& o) {
  require_input(comm, o.input, kMeshInputs);
  MeshSlice mesh = read_mesh(comm, o.input);
  merge_input(comm, o.merge, mesh, nullptr, [&](const std::string& line) {
    if (comm.is_root() && !o.json) fmt::print("{}\n", line);
  });
  const CheckResult result = check_mesh(comm, mesh);
  if (comm.is_root()) fmt::print("{}", o.json ? to_json(result).dump() + "\n" : to_text(result, o.input));
  return result.valid ? ExitCode::kOk : ExitCode::kInvalidMesh;
}

}  // namespace

void add_check(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("check", "Judge a mesh file; tell what is wrong, and where");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb)")->required();
  verb->add_flag("--json", o->json, "print JSON");
  add_merge_option(*verb, o->merge);
  verb->footer("Example: skein check wing.meshb");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return check(comm, *o); }; });
}

}  // namespace skein::app
