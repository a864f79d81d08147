// The metric that the user gives.
#include "app/metric_input.hpp"

#include <fmt/core.h>

#include <utility>

#include "app/numbers.hpp"
#include "base/tensor.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

/// Throws unless the file has one field of the wanted kind, with a value for every vertex.
void require_fit(const FieldSlice& f, const MeshSlice& mesh, FieldKind want) {
  if (f.kinds.size() != 1) {
    throw Error(ExitCode::kInput,
                fmt::format("{}: {} fields at the vertices, but one is wanted", f.path, f.kinds.size()));
  }
  if (f.kinds[0] != want) {
    const char* advice = want == FieldKind::kScalar ? "use --metric for symmetric tensors"
                                                    : "use --size for sizes, or --field for a solution";
    throw Error(ExitCode::kInput,
                fmt::format("{}: {} number(s) per vertex, but {} wanted; {}", f.path, components(f.kinds[0]),
                            want == FieldKind::kScalar ? "one is" : "a symmetric tensor (6) is", advice));
  }
  if (f.total != mesh.total_verts) {
    throw Error(ExitCode::kInput, fmt::format("{}: {} values for the {} vertices of {}; give the one of this mesh",
                                              f.path, f.total, mesh.total_verts, mesh.path));
  }
}

}  // namespace

MetricPolicy MetricOptions::policy() const {
  MetricPolicy p = numbers;
  p.source = !metric.empty() ? MetricSource::kTensors : !size.empty() ? MetricSource::kSizes : MetricSource::kField;
  p.name = path();
  return p;
}

void add_metric_options(CLI::App& verb, MetricOptions& o) {
  auto* metric = verb.add_option("--metric", o.metric, "metric: a symmetric tensor per vertex (.sol, .solb)");
  auto* size = verb.add_option("--size", o.size, "wanted edge length per vertex (.sol, .solb)");
  metric->excludes(size);
  verb.add_option("--complexity", o.numbers.complexity,
                  "scale the metric to this complexity; about 10 tetrahedra per unit")
      ->check(positive());
}

FieldSlice read_metric(const Comm& comm, const MeshSlice& mesh, const MetricOptions& o) {
  FieldSlice f = read_fields(comm, o.path());
  const MetricPolicy policy = o.policy();
  agree(comm, [&] {
    require_fit(f, mesh, policy.kind());
    f = metric_values(std::move(f), policy.source);
  });
  return f;
}

}  // namespace skein::app
