// skein adapt: a mesh and a metric give the adapted mesh.
#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "adapt/method_file.hpp"
#include "api/adaptation.hpp"
#include "app/field_transfer.hpp"
#include "app/files.hpp"
#include "app/help.hpp"
#include "app/merge_input.hpp"
#include "app/metric_input.hpp"
#include "app/numbers.hpp"
#include "app/run_report.hpp"
#include "app/threads.hpp"
#include "app/verbs.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input;
  RunOptions run;
  MetricOptions metric;
  MetricPolicy policy;  ///< of `metric`, once its files are read
  FieldOptions fields;
  std::optional<double> merge;
  AdaptOptions adapt;
  std::string preset = "default", config, points, smoothing;  ///< the last two empty: as the method has it
  bool dump_config = false;
  double ridge_angle = DistributeOptions{}.ridge_angle;
  bool no_surface = false;
  std::string geometry = "patches", geometry_mesh;
  std::optional<double> deviation;
};

/// Collective. What can be said before any file is read.
void require_sense(const Comm& comm, const Options& o) {
  require_metric(comm, o.metric);
  require_input(comm, o.input, kMeshInputs);
  if (!o.geometry_mesh.empty()) require_input(comm, o.geometry_mesh, kMeshInputs);
  require_fields(comm, o.fields, o.run.output);
  std::vector<std::string> inputs = o.metric.files();
  inputs.insert(inputs.end(), o.fields.in.begin(), o.fields.in.end());
  inputs.insert(inputs.end(), {o.input, o.config});
  require_outputs(comm, o.run, inputs, o.fields.out);
}

/// Null where nothing is given and nothing holds.
template <class T>
Json or_null(bool given, T&& value) {
  return given ? Json(std::forward<T>(value)) : Json();
}

/// All options with what holds, defaults included.
Json to_json(const Options& o) {
  const MetricOptions& m = o.metric;
  const MetricPolicy& n = o.policy;
  Json j{{"command", "adapt"}};
  j["metric"] = m.metric, j["size"] = m.size, j["field"] = m.field, j["optim"] = m.optim;
  j["sources"] = m.sources, j["local"] = m.local, j["freeze_ref"] = m.freeze;
  j["norm"] = std::isinf(n.norm) ? Json("inf") : Json(n.norm);
  j["complexity"] = or_null(n.complexity > 0, n.complexity);
  j["elements"] = or_null(m.wanted.elements > 0, m.wanted.elements);
  j["vertices"] = or_null(m.wanted.vertices > 0, m.wanted.vertices);
  j["hmin"] = n.h_min, j["hmax"] = or_null(n.h_max < kNoLargestSize, n.h_max);
  j["aspect_max"] = or_null(n.aspect_max > 0, n.aspect_max);
  j["gradation"] = n.gradation;
  j["max_elements"] = or_null(n.max_tets > 0, n.max_tets);
  j["merge"] = or_null(o.merge.has_value(), o.merge.value_or(0));
  j["field_in"] = o.fields.in, j["field_out"] = o.fields.out;
  j["rounds"] = o.adapt.rounds, j["threads"] = o.adapt.threads;
  j["method"] = o.preset, j["config"] = o.config;
  j["points"] = o.adapt.method.points == PointCreation::kCentroids ? "centroid" : "edges";
  j["smoothing"] = o.adapt.method.smoothing == Smoothing::kSprings ? "springs" : "quality";
  j["ridge_angle"] = o.ridge_angle, j["surface"] = !o.no_surface;
  j["geometry"] = o.geometry;
  if (!o.geometry_mesh.empty()) j["geometry_mesh"] = o.geometry_mesh;
  if (o.deviation) j["deviation"] = *o.deviation;
  return j;
}

/// Collective. Reads mesh, metric and fields.
AdaptationInput read_input(const Comm& comm, const Options& o, RunRecord& record, FieldsOut& fields) {
  record.log.start("read");
  AdaptationInput input;
  const auto note = [&](const std::string& line) { record.log.note(line); };
  input.mesh = read_mesh_noting(comm, o.input, note);
  require_tets(comm, input.mesh);
  if (!o.geometry_mesh.empty()) input.geometry = read_mesh(comm, o.geometry_mesh);
  input.values = read_metric(comm, input.mesh, o.metric);
  const int metric_width = input.values.width;
  fields = read_fields_behind(comm, input.mesh, o.fields, input.values);
  input.carried = input.values.width - metric_width;
  merge_input(comm, o.merge, input.mesh, &input.values, note);
  apply_to_entities(comm, o.policy.local, input.mesh);
  record.elements_in = input.mesh.tets.total, record.vertices_in = input.mesh.total_verts;
  record.log.finish(static_cast<std::int64_t>(input.mesh.tets.verts.size()));
  record.lap("read");
  return input;
}

AdaptationOptions to_adaptation(const Options& o) {
  AdaptationOptions a;
  a.distribute.ridge_angle = o.ridge_angle;
  a.metric = o.policy;
  a.wanted = o.metric.wanted;
  a.adapt = o.adapt;
  a.adapt.threads = o.run.threads;
  a.adapt.surface = !o.no_surface;
  a.geometry = o.geometry == "facets" ? SurfaceShape::kFacets : SurfaceShape::kPatches;
  if (o.deviation) a.deviation = {*o.deviation, 0};
  return a;
}

/// Collective. The preset, or the file's method, with what the command line changes in it.
Method choose_method(const Comm& comm, const Options& o) {
  Method m = o.config.empty() ? find_preset(o.preset).method : read_method(comm, o.config);
  if (!o.points.empty()) m.points = o.points == "centroid" ? PointCreation::kCentroids : PointCreation::kEdges;
  if (!o.smoothing.empty()) m.smoothing = o.smoothing == "springs" ? Smoothing::kSprings : Smoothing::kQuality;
  return m;
}

ExitCode run_adapt(const Comm& comm, Options& o) {
  o.adapt.method = choose_method(comm, o);
  if (o.dump_config) {
    if (comm.is_root()) fmt::print("{}", method_to_toml(o.adapt.method, o.preset));
    return ExitCode::kOk;
  }
  require_sense(comm, o);
  o.policy = read_policy(comm, o.metric);
  o.run.threads = settle_threads(comm, o.run.threads);
  RunRecord record(comm, o.run);
  record.input = o.input;
  o.adapt.threads = o.run.threads;
  record.options = to_json(o);
  note_head(comm, o.run.threads, record.log);
  note_threads(comm, o.run.threads, record.log);
  FieldsOut fields;
  AdaptationInput input = read_input(comm, o, record, fields);
  AdaptationOptions options = to_adaptation(o);
  if (o.policy.has_sources()) options.adapt.spacing = &options.metric.sources;
  options.suspect = [&](DistMesh&& dist) { write_suspect(comm, o.run.output, std::move(dist)); };
  AdaptationReport told;
  DistMesh dist = run_adaptation(
      comm, std::move(input), options, record.log, [&](const std::string& step) { record.lap(step); }, &told);
  record.end_check = skein::to_json(told.end_check);
  if (told.surface) record.surface = skein::to_json(*told.surface);
  record.before = std::move(told.before);
  record.predicted_tets = told.predicted_tets;
  note_rounds(comm, record.log, o.adapt.rounds);
  record.finish(comm, std::move(dist), fields);
  return ExitCode::kOk;
}

/// Options of what the boundary stands for.
void add_surface_options(CLI::App& verb, Options& o) {
  verb.add_option("--ridge-angle", o.ridge_angle, "surface edges folded more than this are kept, degrees")
      ->check(CLI::Range(0.0, 180.0));
  verb.add_flag("--no-surface", o.no_surface, "keep the boundary triangles as they are");
  verb.add_option("--geometry", o.geometry, "how the boundary runs between the vertices of IN: curved or flat")
      ->check(CLI::IsMember({"patches", "facets"}));
  verb.add_option(
      "--geometry-mesh", o.geometry_mesh,
      "mesh whose boundary is the geometry, with the same references: the first one, where passes are chained");
  verb.add_option("--deviation", o.deviation,
                  "how far the boundary may be off that of IN, relative to the bounding box of each smooth piece; "
                  "0.001, and less where bodies are thin")
      ->check(CLI::Range(0.0, 1.0));
}

/// Options that choose the method and its numbers.
void add_method_options(CLI::App& verb, Options& o) {
  std::vector<std::string> names;
  for (const Preset& p : presets()) names.emplace_back(p.name);
  auto* preset = verb.add_option("--method-preset", o.preset, "method with its numbers: default, chapter or quick")
                     ->check(CLI::IsMember(names));
  verb.add_option("--config", o.config, "numbers of the method (TOML, as --dump-config prints them)")->excludes(preset);
  verb.add_flag("--dump-config", o.dump_config, "print the method with all its numbers, and end");
  verb.add_option("--points", o.points, "how points are created: edges or centroid")
      ->check(CLI::IsMember({"edges", "centroid"}));
  verb.add_option("--smoothing", o.smoothing, "how vertices are moved: quality or springs")
      ->check(CLI::IsMember({"quality", "springs"}));
}

}  // namespace

void add_adapt(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("adapt", "Adapt a mesh to a metric, to sizes, or to a solution");
  auto* in = verb->add_option("IN", o->input, "mesh (.mesh, .meshb)");
  add_metric_options(*verb, o->metric);
  add_adapt_metric_options(*verb, o->metric);
  add_run_options(*verb, o->run);
  verb->get_option("--output")->required(false);  // neither is needed with --dump-config
  add_field_options(*verb, o->fields);
  add_merge_option(*verb, o->merge);
  verb->add_option("--rounds", o->adapt.rounds,
                   "rounds over the processes (MPI ranks), at most: in each the borders between them move (3)")
      ->check(CLI::Range(1, 100));
  add_method_options(*verb, *o);
  add_surface_options(*verb, *o);
  group(
      *verb, "What the mesh is adapted to",
      {"--metric", "--size", "--field", "--optim", "--sources", "--complexity", "--elements", "--vertices", "--norm"});
  group(
      *verb, "Bounds, and what stays",
      {"--hmin", "--hmax", "--aspect-max", "--gradation", "--local", "--freeze-ref", "--no-surface", "--max-elements"});
  group(*verb, "Files",
        {"--output", "--field-in", "--field-out", "--metric-out", "--report", "--format-version", "--overwrite-input",
         "--merge"});
  group(
      *verb, "Method and run",
      {"--rounds", "--threads", "--quiet", "--method-preset", "--config", "--dump-config", "--points", "--smoothing"});
  verb->footer("Example: mpirun -n 4 skein adapt wing.meshb --metric wing.solb --complexity 50000 -o fine.meshb");
  verb->callback([o, in, verb, &run] {
    for (const CLI::Option* needed : {in, verb->get_option("--output")}) {
      if (!o->dump_config && needed->empty()) throw CLI::RequiredError(needed->get_name());
    }
    run = [o](const Comm& comm) { return run_adapt(comm, *o); };
  });
}

}  // namespace skein::app
