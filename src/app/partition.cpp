// skein partition: cut a mesh into parts, tell how good the cut is.
#include "dist/partition.hpp"

#include <fmt/core.h>

#include <memory>

#include "app/files.hpp"
#include "app/threads.hpp"
#include "app/verbs.hpp"
#include "base/text.hpp"
#include "dist/distribute.hpp"
#include "dist/gather_slices.hpp"
#include "io/mesh_io.hpp"
#include "report/json.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input, output;
  int parts = 0, threads = kThreadsNotGiven;
  std::string method = "multilevel";
  bool json = false;
  GmfVersion format = GmfVersion::kLowest;
  InputFiles inputs = InputFiles::kKept;
};

ExitCode run_partition(const Comm& comm, const Options& o) {
  require_distinct(comm, {o.input}, {o.output}, o.inputs);
  require_input(comm, o.input, kMeshInputs);
  require_output(comm, o.output, kMeshOutputs);
  const MeshSlice mesh = read_mesh(comm, o.input);
  require_tets(comm, mesh);
  DistMesh dist = distribute(comm, mesh);

  const int threads = settle_threads(comm, o.threads);
  const double begin = wall_time();
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  const auto method = o.method == "hilbert" ? PartitionMethod::kHilbert : PartitionMethod::kMultilevel;
  const IdVector<TetId, PartId> part = partition(comm, dist, work, o.parts, method, threads);
  const double seconds = comm.max(wall_time() - begin);
  const PartitionStats s = partition_stats(comm, dist, part, work, o.parts);

  if (!o.output.empty()) {
    for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) dist.mesh.tet_ref[t] = num(part[t]);
    write_mesh(comm, o.output, to_slices(comm, dist), nullptr, o.format);
  }
  if (!comm.is_root()) return ExitCode::kOk;
  if (o.json) {
    const Json j{{"parts", o.parts},         {"tets", dist.global_tets},   {"cut_faces", s.cut_faces},
                 {"imbalance", s.imbalance}, {"components", s.components}, {"seconds", seconds}};
    fmt::print("{}\n", j.dump());
  } else {
    fmt::print("{} tetrahedra in {} parts: {} faces cut, imbalance {:.2f} %, {} connected pieces, {:.2f} s\n",
               grouped(dist.global_tets), o.parts, grouped(s.cut_faces), 100 * s.imbalance, s.components, seconds);
  }
  return ExitCode::kOk;
}

}  // namespace

void add_partition(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("partition", "Cut a mesh into parts, tell how good the cut is");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb)")->required();
  verb->add_option("--parts", o->parts, "number of parts")->required()->check(CLI::Range(1, 1 << 20));
  verb->add_option("--method", o->method, "multilevel: short interfaces; hilbert: pieces of a curve, quick")
      ->check(CLI::IsMember({"multilevel", "hilbert"}))
      ->capture_default_str();
  add_threads_option(*verb, o->threads);
  verb->add_option("-o,--output", o->output, "the mesh with the part, from 0, as reference of the tetrahedra");
  add_format_option(*verb, o->format);
  add_overwrite_option(*verb, o->inputs);
  verb->add_flag("--json", o->json, "print JSON");
  verb->footer("Example: skein partition wing.meshb --parts 16 -o parts.vtu");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return run_partition(comm, *o); }; });
}

}  // namespace skein::app
