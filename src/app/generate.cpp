// skein generate: a closed surface triangulation gives a volume mesh.
#include "generate/generate.hpp"

#include <memory>

#include "app/files.hpp"
#include "app/numbers.hpp"
#include "app/run_report.hpp"
#include "app/threads.hpp"
#include "app/verbs.hpp"
#include "generate/sources_file.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input, sources;
  RunOptions run;
  GenerateOptions generate;
};

Json to_json(const Options& o) {
  Json j{{"command", "generate"}};
  j["sources"] = o.sources;
  j["size_max"] = o.generate.size_max < 1e300 ? Json(o.generate.size_max) : Json();
  j["growth"] = o.generate.growth, j["ridge_angle"] = o.generate.ridge_angle;
  j["keep_surface"] = o.generate.keeps_surface();
  j["rounds"] = o.generate.adapt.rounds, j["threads"] = o.generate.adapt.threads;
  return j;
}

ExitCode run_generate(const Comm& comm, Options& o) {
  require_input(comm, o.input, kMeshInputs);
  require_outputs(comm, o.run, {o.input, o.sources});
  o.run.threads = settle_threads(comm, o.run.threads);
  o.generate.adapt.threads = o.run.threads;
  RunRecord record(comm, o.run);
  record.input = o.input;
  note_head(comm, o.run.threads, record.log);
  note_threads(comm, o.run.threads, record.log);

  record.log.start("read");
  const MeshSlice surface = read_mesh_noting(comm, o.input, [&](const std::string& line) { record.log.note(line); });
  if (!o.sources.empty()) o.generate.sources = read_sources(comm, o.sources);
  record.options = to_json(o);
  record.elements_in = surface.triangles.total, record.vertices_in = surface.total_verts;
  record.log.finish(0);
  record.lap("read");

  DistMesh dist = generate(comm, surface, o.generate, record.log);
  record.lap("generate");
  record.finish(comm, std::move(dist));
  return ExitCode::kOk;
}

}  // namespace

void add_generate(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("generate", "Fill a closed surface with tetrahedra");
  verb->add_option("SURFACE", o->input, "surface (.mesh, .meshb)")->required();
  add_run_options(*verb, o->run);
  verb->add_option("--sources", o->sources, "spacing sources (TOML)");
  verb->add_option("--size-max", o->generate.size_max, "largest edge length")->check(positive());
  verb->add_option("--growth", o->generate.growth, "how fast the boundary spacing may grow inwards, per distance")
      ->check(positive());
  verb->add_option("--ridge-angle", o->generate.ridge_angle, "surface edges folded more than this are kept, degrees")
      ->check(CLI::Range(0.0, 180.0));
  using Surface = GenerateOptions::Surface;
  auto* keep = verb->add_flag_callback(
      "--keep-surface", [o] { o->generate.surface = Surface::kKept; },
      "keep the surface triangles as they are; so it is without --sources and --size-max");
  verb->add_flag_callback(
          "--remesh-surface", [o] { o->generate.surface = Surface::kRemeshed; },
          "adapt the surface to its own spacing, also where no sizes are given")
      ->excludes(keep);
  verb->add_option("--rounds", o->generate.adapt.rounds,
                   "rounds over the processes (MPI ranks), at most: in each the borders between them move (3)")
      ->check(CLI::Range(1, 100));
  verb->footer("Example: mpirun -n 2 skein generate wing-body.mesh --sources wing.toml -o wing-body.meshb");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return run_generate(comm, *o); }; });
}

}  // namespace skein::app
