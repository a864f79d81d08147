// What a run that makes a mesh has in common.
#include "app/run_report.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/files.hpp"
#include "app/large_blocks.hpp"
#include "base/tensor.hpp"
#include "base/text.hpp"
#include "dist/gather_slices.hpp"
#include "io/mesh_io.hpp"
#include "report/cell_arrays.hpp"
#include "report/statistics.hpp"
#include "report/statistics_json.hpp"

namespace skein::app {
namespace {

const char* kLaunchers[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "SLURM_PROCID"};

/// The metric itself, from its logarithm.
FieldSlice metric_slices(const Comm& comm, const DistMesh& dist) {
  FieldSlice f = to_metric_slices(comm, dist);
  for (std::size_t i = 0; i + 6 <= f.values.size(); i += 6) {
    double* v = f.values.data() + i;
    const SymTensor m = exp(SymTensor{v[0], v[1], v[2], v[3], v[4], v[5]});
    v[0] = m.xx, v[1] = m.xy, v[2] = m.yy, v[3] = m.xz, v[4] = m.yz, v[5] = m.zz;
  }
  return f;
}

}  // namespace

void add_run_options(CLI::App& verb, RunOptions& o) {
  verb.add_option("-o,--output", o.output, "mesh to write (.mesh, .meshb, .vtu, .pvtu)")->required();
  verb.add_option("--report", o.report, "write a report of the run (JSON)");
  verb.add_option("--metric-out", o.metric_out, "write the metric at the vertices of the new mesh (.sol, .solb)");
  add_threads_option(verb, o.threads);
  add_format_option(verb, o.format);
  add_overwrite_option(verb, o.inputs);
  verb.add_flag("--quiet", o.quiet, "no progress");
}

void require_outputs(const Comm& comm, const RunOptions& o, const std::vector<std::string>& inputs,
                     const std::string& more) {
  require_distinct(comm, inputs, {o.output, o.metric_out, o.report, more}, o.inputs);
  require_output(comm, o.output, kMeshOutputs);
  require_output(comm, o.metric_out, kFields);
  require_output(comm, o.report, {});
}

std::string suspect_path(const std::string& output) {
  const std::filesystem::path path(output);
  return (path.parent_path() / (path.stem().string() + ".suspect" + path.extension().string())).string();
}

void write_suspect(const Comm& comm, const std::string& output, DistMesh dist) {
  const MeshSlice mesh = to_slices(comm, dist);
  dist = {};
  write_mesh(comm, suspect_path(output), mesh);
}

void note_head(const Comm& comm, int threads, PhaseLog& log) {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  const std::time_t now = std::time(nullptr);
  char date[32] = "";
  std::strftime(date, sizeof date, "%Y-%m-%d %H:%M:%S", std::localtime(&now));
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  std::string command(std::istreambuf_iterator<char>(in), {});
  if (!command.empty() && command.back() == '\0') command.pop_back();
  std::replace(command.begin(), command.end(), '\0', ' ');
  log.note(fmt::format("skein {}, {} on {}: {} process{} x {} thread{}", SKEIN_VERSION, date, host, comm.size(),
                       comm.size() == 1 ? "" : "es", threads, threads == 1 ? "" : "s"));
  log.note(command);
}

void note_rounds(const Comm& comm, PhaseLog& log, int most) {
  int rounds = 0;
  for (const PhaseCost& p : log.phases()) {
    if (p.name == "round 1: adapt") rounds = 0;  // it has begun again
    if (p.name.starts_with("round ") && p.name.ends_with(": adapt")) ++rounds;
  }
  const char* why = comm.size() == 1 ? "one process has no interfaces to move"
                    : rounds == 1    ? "the mesh was too small to be cut"
                    : rounds < most  ? "nothing was left to do at the old interfaces"
                    : rounds == most ? "as many as asked for"
                                     : "the last ones mended what was left at old interfaces";
  log.note(fmt::format("rounds: {} ({})", rounds, why));
}

PhaseLog::Output progress_output(const RunOptions& options) {
  if (options.quiet) return PhaseLog::Output::kQuiet;
  for (const char* name : kLaunchers) {
    if (std::getenv(name) != nullptr) return PhaseLog::Output::kPlain;
  }
  return isatty(STDOUT_FILENO) != 0 ? PhaseLog::Output::kTerminal : PhaseLog::Output::kPlain;
}

RunRecord::RunRecord(const Comm& comm, const RunOptions& options)
    : log(comm, progress_output(options)), run_(options), begin_(wall_time()), lap_(begin_) {
  constexpr double kSeconds = 30;
  log.beat_every(kSeconds);
}

void RunRecord::lap(const std::string& name) {
  const double now = wall_time();
  laps_.emplace_back(name, now - lap_);
  lap_ = now;
}

void RunRecord::finish(const Comm& comm, DistMesh dist, const FieldsOut& fields) {
  log.start("statistics");
  const MeshStatistics s = statistics(comm, dist, Measure::kInMetric, run_.threads);
  const Census after = census(comm, dist);
  const std::vector<WorstTet> worst = worst_tets(comm, dist, 1, Measure::kInMetric);
  log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  lap("statistics");

  log.start("write");
  const auto tets = static_cast<std::int64_t>(dist.mesh.tet_slots());
  FieldSlice values, metric;
  if (!fields.kinds.empty()) {
    values = to_field_slices(comm, dist, fields.kinds);
    values.names = fields.names;
  }
  FieldSlice drawn, cells;
  const bool vtk = has_ending(run_.output, {".vtu", ".pvtu"});
  if (vtk) {
    drawn = with_metric_arrays(comm, dist, values);
    cells = cell_arrays(comm, dist, Measure::kInMetric);
  }
  if (!run_.metric_out.empty()) metric = metric_slices(comm, dist);
  MeshSlice mesh = to_slices(comm, dist);
  // The system copies what is written, and memory that it has back is faster than such as nobody has used before.
  dist.mesh = {}, dist.vert2gid = {};
  give_back_spare_blocks();
  write_mesh(comm, run_.output, mesh, vtk ? &drawn : nullptr, run_.format, vtk ? &cells : nullptr);
  mesh = {};
  if (!fields.path.empty()) write_fields(comm, fields.path, values, run_.format);
  if (!run_.metric_out.empty()) write_fields(comm, run_.metric_out, metric, run_.format);
  log.finish(tets);
  lap("write");

  note_result(s, after, worst);
  Json report = to_json(comm, dist, skein::to_json(s));
  report.update(skein::to_json(before, after));
  if (!worst.empty()) report["worst"] = skein::to_json(worst[0]);
  if (!run_.report.empty()) write_json(comm, run_.report, report);
}

void RunRecord::note_result(const MeshStatistics& s, const Census& after, const std::vector<WorstTet>& worst) {
  if (!before.regions.empty()) {
    log.note("elements before and after:");
    for (const std::string& line : to_lines(before, after)) log.note(line);
  }
  if (predicted_tets > 0)
    log.note(fmt::format("{:.1f} % of the {} tetrahedra expected; complexity {:.4g}",
                         100 * static_cast<double>(s.tets) / predicted_tets, grouped(std::llround(predicted_tets)),
                         s.complexity));
  const double other = 100 - s.length.unit_share;
  log.note(
      fmt::format("edges far from unit length (below 0.71 or above 1.41 in the metric): {:.2f} %; below 0.5: {:.3f} %, "
                  "above 2: {:.3f} %",
                  other, s.length.below_half, s.length.above_two));
  if (!worst.empty()) log.note("worst element: " + to_line(worst[0]));
  log.note(fmt::format(
      "{}: {} tetrahedra, {} vertices; edges near unit length {:.2f} %, quality min {:.3f}, 1 % {:.3f}, mean {:.3f}",
      run_.output, grouped(s.tets), grouped(s.vertices), s.length.unit_share, s.quality.min, s.quality.p1,
      s.quality.mean));
}

Json RunRecord::to_json(const Comm& comm, const DistMesh& dist, const Json& statistics) const {
  Json seconds{{"total", comm.max(wall_time() - begin_)}};
  for (const auto& [name, s] : laps_) seconds[name] = comm.max(s);
  Json phases = Json::array();
  for (const PhaseCost& p : log.phases()) phases.push_back(skein::to_json(p));
  Json report{{"version", SKEIN_VERSION},
              {"input", input},
              {"output", run_.output},
              {"options", options},
              {"ranks", comm.size()},
              {"threads", run_.threads},
              {"elements_in", elements_in},
              {"elements_out", dist.global_tets},
              {"vertices_in", vertices_in},
              {"vertices_out", dist.global_verts},
              {"elements_expected", predicted_tets > 0 ? Json(predicted_tets) : Json()},
              {"seconds", seconds},
              {"peak_bytes", comm.all_gather(peak_memory())},
              {"phases", phases}};
  if (!end_check.is_null()) report["end_check"] = end_check;
  if (!surface.is_null()) report["surface"] = surface;
  for (const char* key : {"complexity", "tets_per_complexity", "edges", "length", "quality", "dihedral", "volume"}) {
    report[key] = statistics.at(key);
  }
  return report;
}

}  // namespace skein::app
