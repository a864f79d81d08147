// skein stats: sizes, edge lengths and quality in a metric, dihedral angles.
#include <fmt/core.h>

#include <memory>

#include "app/files.hpp"
#include "app/metric_input.hpp"
#include "app/verbs.hpp"
#include "dist/distribute.hpp"
#include "io/mesh_io.hpp"
#include "report/statistics.hpp"
#include "report/statistics_json.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input;
  MetricOptions metric;
  bool json = false;
};

ExitCode stats(const Comm& comm, const Options& o) {
  require_input(comm, o.input, kMeshInputs);
  for (const std::string& path : o.metric.files()) require_input(comm, path, kFields);
  const MeshSlice mesh = read_mesh(comm, o.input);
  require_tets(comm, mesh);
  FieldSlice metric;
  MetricPolicy policy = o.metric.numbers;
  policy.source = o.metric.source();
  if (o.metric.given()) metric = read_metric(comm, mesh, o.metric);
  DistributeOptions options;
  options.metric_first = o.metric.field.empty();
  DistMesh dist = distribute(comm, mesh, o.metric.given() ? &metric : nullptr, options);
  if (o.metric.given()) make_metric(comm, dist, policy);
  const MeshStatistics s = statistics(comm, dist, o.metric.given() ? Measure::kInMetric : Measure::kInSpace);
  if (comm.is_root()) fmt::print("{}", o.json ? to_json(s).dump() + "\n" : to_text(s));
  return ExitCode::kOk;
}

}  // namespace

void add_stats(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("stats", "Sizes, edge lengths and quality in a metric, dihedral angles");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb)")->required();
  add_metric_options(*verb, o->metric);
  verb->add_flag("--json", o->json, "print JSON");
  verb->footer("Example: skein stats wing.meshb --metric wing.solb --complexity 50000");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return stats(comm, *o); }; });
}

}  // namespace skein::app
