// skein adapt: a mesh and a metric give the adapted mesh.
#include "adapt/adapt.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "app/field_transfer.hpp"
#include "app/files.hpp"
#include "app/metric_input.hpp"
#include "app/run_report.hpp"
#include "app/threads.hpp"
#include "app/verbs.hpp"
#include "base/text.hpp"
#include "dist/distribute.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

constexpr double kSizeGradation = 1.3;  ///< of --size, unless told otherwise

struct Options {
  std::string input;
  RunOptions run;
  MetricOptions metric;
  FieldOptions fields;
  std::optional<double> gradation;
  AdaptOptions adapt;
  std::string points = "edges", smoothing = "quality";
  double ridge_angle = DistributeOptions{}.ridge_angle;
  bool no_surface = false;
};

/// Collective. What can be said before any file is read.
void require_sense(const Comm& comm, const Options& o) {
  agree(comm, [&] {
    const auto fail = [](const char* line) { throw Error(ExitCode::kUsage, line); };
    if (!o.metric.given()) fail("adapt: one of --metric, --size, --field is needed; see: skein adapt --help");
    if (!o.metric.field.empty() && o.metric.numbers.complexity <= 0) {
      fail("adapt: --field needs --complexity, which tells how many elements there shall be (about a tenth of them)");
    }
    if (o.metric.numbers.h_min > o.metric.numbers.h_max) fail("adapt: --hmin is greater than --hmax");
    if (o.metric.numbers.gradation != 0 && o.metric.numbers.gradation <= 1) {
      fail("adapt: --gradation must be greater than 1 (usual: 1.2 to 2), or 0 for none");
    }
  });
  require_input(comm, o.input, kMeshInputs);
  require_input(comm, o.metric.path(), kFields);
  require_fields(comm, o.fields, o.run.output);
  require_outputs(comm, o.run);
}

Json to_json(const Options& o) {
  Json j{{"verb", "adapt"}};
  if (!o.metric.metric.empty()) j["metric"] = o.metric.metric;
  if (!o.metric.size.empty()) j["size"] = o.metric.size;
  if (!o.metric.field.empty()) j["field"] = o.metric.field;
  if (!o.metric.field.empty())
    j["norm"] = std::isinf(o.metric.numbers.norm) ? Json("inf") : Json(o.metric.numbers.norm);
  if (o.metric.numbers.complexity > 0) j["complexity"] = o.metric.numbers.complexity;
  if (o.metric.numbers.h_min > 0) j["hmin"] = o.metric.numbers.h_min;
  if (o.metric.numbers.h_max < kNoLargestSize) j["hmax"] = o.metric.numbers.h_max;
  if (o.metric.numbers.gradation > 0) j["gradation"] = o.metric.numbers.gradation;
  if (!o.fields.in.empty()) j["field_in"] = o.fields.in;
  if (!o.fields.out.empty()) j["field_out"] = o.fields.out;
  j["rounds"] = o.adapt.rounds, j["threads"] = o.adapt.threads, j["points"] = o.points;
  j["smoothing"] = o.smoothing;
  j["ridge_angle"] = o.ridge_angle, j["surface"] = !o.no_surface;
  return j;
}

void note_findings(PhaseLog& log, const DistributeReport& r) {
  const auto note = [&](std::int64_t n, const char* what) {
    if (n > 0) log.note(fmt::format("note: {} {}", grouped(n), what));
  };
  if (r.flipped) log.note("note: all tetrahedra were negatively oriented and have been turned");
  note(r.untagged_hull_faces, "faces of the hull have no triangle in the file; they become a patch of their own");
  note(r.untagged_region_faces, "faces between regions have no triangle in the file; they become a patch of their own");
  note(r.unused_verts, "vertices of no tetrahedron are dropped");
  note(r.lost_edges, "edges of the file are no edge of a tetrahedron and are dropped");
}

void note_gradation(PhaseLog& log, const GradationReport& r, std::int64_t vertices) {
  if (r.lowered > 0) {
    log.note(fmt::format("gradation: stricter at {} of {} vertices", grouped(r.lowered), grouped(vertices)));
  }
  if (!r.converged) log.note("note: the gradation has not converged; sizes may still grow faster in places");
}

/// Collective. Reading and distribution; the slices of the files are gone when it returns.
DistMesh load(const Comm& comm, const Options& o, RunRecord& record, TravellingFields& fields) {
  PhaseLog& log = record.log;
  log.start("read");
  const MeshSlice mesh = read_mesh(comm, o.input);
  FieldSlice metric = read_metric(comm, mesh, o.metric);
  metric = fields.read_behind(comm, mesh, std::move(metric));
  record.elements_in = mesh.tets.total, record.vertices_in = mesh.total_verts;
  log.finish(static_cast<std::int64_t>(mesh.tets.verts.size()));
  record.lap("read");

  log.start("distribute");
  DistributeReport found;
  DistributeOptions options;
  options.ridge_angle = o.ridge_angle;
  options.metric_first = o.metric.field.empty();
  DistMesh dist = distribute(comm, mesh, &metric, options, &found);
  fields.take_from(dist, options.metric_first ? 0 : 1);
  log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  note_findings(log, found);

  log.start("metric");
  const GradationReport graded = make_metric(comm, dist, o.metric.policy());
  fields.keep_mesh(comm, dist);
  log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  note_gradation(log, graded, dist.global_verts);
  record.lap("distribute");
  return dist;
}

ExitCode run_adapt(const Comm& comm, Options& o) {
  o.metric.numbers.gradation = o.gradation.value_or(o.metric.size.empty() ? 0 : kSizeGradation);
  require_sense(comm, o);
  o.run.threads = settle_threads(comm, o.run.threads);
  RunRecord record(comm, o.run);
  record.input = o.input;
  o.adapt.threads = o.run.threads;
  o.adapt.method.points = o.points == "centroid" ? PointCreation::kCentroids : PointCreation::kEdges;
  o.adapt.method.smoothing = o.smoothing == "springs" ? Smoothing::kSprings : Smoothing::kQuality;
  o.adapt.surface = !o.no_surface;
  record.options = to_json(o);
  note_threads(comm, o.run.threads, record.log);
  TravellingFields fields(o.fields);
  DistMesh dist = load(comm, o, record, fields);
  adapt(comm, dist, o.adapt, record.log);
  record.lap("adapt");
  fields.arrive(dist, o.run.threads, record.log);
  if (fields.any()) record.lap("transfer");
  record.finish(comm, std::move(dist), fields.out());
  return ExitCode::kOk;
}

}  // namespace

void add_adapt(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("adapt", "Adapt a mesh to a metric, to sizes, or to a solution");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb)")->required();
  add_run_options(*verb, o->run);
  add_metric_options(*verb, o->metric);
  verb->add_option("--field", o->metric.field, "solution, a scalar per vertex: adapt to its second derivatives")
      ->excludes("--metric")
      ->excludes("--size");
  verb->add_option("--norm", o->metric.numbers.norm, "with --field: the error's norm, 1, 2, 4 ... or inf")
      ->check(CLI::Range(1.0, std::numeric_limits<double>::infinity()));
  verb->add_option("--hmin", o->metric.numbers.h_min, "smallest edge length")->check(CLI::PositiveNumber);
  verb->add_option("--hmax", o->metric.numbers.h_max, "largest edge length")->check(CLI::PositiveNumber);
  verb->add_option("--gradation", o->gradation,
                   "sizes grow at most by this factor per edge (> 1; 0: no bound); 1.3 with --size, else 0");
  add_field_options(*verb, o->fields);
  verb->add_option("--rounds", o->adapt.rounds, "rounds over the processes")->check(CLI::Range(1, 100));
  verb->add_option("--points", o->points, "how points are created")->check(CLI::IsMember({"edges", "centroid"}));
  verb->add_option("--smoothing", o->smoothing, "how vertices are moved")->check(CLI::IsMember({"quality", "springs"}));
  verb->add_option("--ridge-angle", o->ridge_angle, "surface edges folded more than this are kept, degrees")
      ->check(CLI::Range(0.0, 180.0));
  verb->add_flag("--no-surface", o->no_surface, "keep the boundary triangles as they are");
  verb->footer("Example: mpirun -n 4 skein adapt wing.meshb --metric wing.solb --complexity 50000 -o fine.meshb");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return run_adapt(comm, *o); }; });
}

}  // namespace skein::app
