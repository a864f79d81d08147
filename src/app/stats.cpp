// skein stats: sizes, edge lengths and quality in a metric, dihedral angles.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "app/files.hpp"
#include "app/metric_input.hpp"
#include "app/verbs.hpp"
#include "dist/distribute.hpp"
#include "io/mesh_io.hpp"
#include "report/census.hpp"
#include "report/statistics.hpp"
#include "report/statistics_json.hpp"

namespace skein::app {
namespace {

struct Options {
  std::string input;
  MetricOptions metric;
  bool json = false;
  int worst = 0;
};

/// Collective. The numbers, from 1, that these have in the file; the mesh was reordered when it was distributed.
std::vector<std::int64_t> numbers_in_file(const Comm& comm, const MeshSlice& mesh, const std::vector<WorstTet>& tets) {
  std::map<std::array<GlobalId, 4>, std::size_t> wanted;
  for (std::size_t i = 0; i < tets.size(); ++i) wanted[tets[i].verts] = i;
  std::vector<std::int64_t> number(tets.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.verts.size() && !wanted.empty(); ++t) {
    auto key = mesh.tets.verts[t];
    std::sort(key.begin(), key.end());
    const auto at = wanted.find(key);
    if (at != wanted.end()) number[at->second] = mesh.tets.first + static_cast<std::int64_t>(t) + 1;
  }
  comm.reduce(std::span<std::int64_t>(number), Op::kMax);
  return number;
}

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
  const Measure measure = o.metric.given() ? Measure::kInMetric : Measure::kInSpace;
  const std::vector<WorstTet> worst = worst_tets(comm, dist, static_cast<std::size_t>(o.worst), measure);
  const std::vector<std::int64_t> number = numbers_in_file(comm, mesh, worst);
  if (!comm.is_root()) return ExitCode::kOk;
  if (!o.json) fmt::print("{}", to_text(s));
  Json j = to_json(s);
  for (std::size_t i = 0; i < worst.size(); ++i) {
    if (!o.json) fmt::print("{}tetrahedron {}: {}\n", i == 0 ? "\n" : "", number[i], to_line(worst[i]));
    j["worst"].push_back(to_json(worst[i]));
    j["worst"].back()["tetrahedron"] = number[i];
  }
  if (o.json) fmt::print("{}\n", j.dump());
  return ExitCode::kOk;
}

}  // namespace

void add_stats(CLI::App& cli, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = cli.add_subcommand("stats", "Edge lengths, quality and angles; the worst elements");
  verb->add_option("IN", o->input, "mesh (.mesh, .meshb)")->required();
  add_metric_options(*verb, o->metric);
  verb->add_option("--worst", o->worst, "list so many elements of least quality, and where they are")
      ->check(CLI::Range(0, 10000));
  verb->add_flag("--json", o->json, "print JSON");
  verb->footer("Example: skein stats wing.meshb --metric wing.solb --complexity 50000");
  verb->callback([o, &run] { run = [o](const Comm& comm) { return stats(comm, *o); }; });
}

}  // namespace skein::app
