// The metric that the user gives.
#include "app/metric_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/tensor.hpp"
#include "io/mesh_io.hpp"
#include "report/statistics.hpp"
#include "solution/hessian.hpp"
#include "solution/hessian_metric.hpp"

namespace skein::app {
namespace {

constexpr int kMostScalings = 10;
constexpr double kComplexityTolerance = 1e-3;

/// Throws unless the file has one field of the wanted kind, with a value for every vertex.
void require_fit(const FieldSlice& f, const MeshSlice& mesh, const MetricOptions& o) {
  const FieldKind want = o.metric.empty() ? FieldKind::kScalar : FieldKind::kTensor;
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

SymTensor logarithm(const SymTensor& m, const std::string& path, std::int64_t vertex) {
  if (!is_finite(m)) {
    throw Error(ExitCode::kInput, fmt::format("{}: the metric at vertex {} is not finite", path, vertex));
  }
  if (!is_positive_definite(m)) {
    const Eigen e = eigen(m);
    throw Error(ExitCode::kInput,
                fmt::format("{}: the metric at vertex {} is not positive definite: eigenvalues {:.6g}, {:.6g}, {:.6g}",
                            path, vertex, e.value[0], e.value[1], e.value[2]));
  }
  return log(m);
}

void put(const SymTensor& l, double* out) noexcept {
  out[0] = l.xx, out[1] = l.xy, out[2] = l.yy, out[3] = l.xz, out[4] = l.yz, out[5] = l.zz;
}

FieldSlice log_of_tensors(FieldSlice f) {
  for (std::size_t i = 0; i < f.values.size() / 6; ++i) {
    double* v = f.values.data() + 6 * i;
    put(logarithm({v[0], v[1], v[2], v[3], v[4], v[5]}, f.path, f.first + static_cast<std::int64_t>(i) + 1), v);
  }
  return f;
}

FieldSlice log_of_sizes(const FieldSlice& sizes) {
  FieldSlice f;
  f.path = sizes.path, f.total = sizes.total, f.first = sizes.first;
  f.kinds = {FieldKind::kTensor}, f.width = 6;
  f.values.resize(6 * sizes.values.size());
  for (std::size_t i = 0; i < sizes.values.size(); ++i) {
    const double h = sizes.values[i];
    if (!(h > 0) || !std::isfinite(h)) {
      throw Error(ExitCode::kInput, fmt::format("{}: the size at vertex {} is {:.6g}; sizes must be greater than zero",
                                                f.path, f.first + static_cast<std::int64_t>(i) + 1, h));
    }
    put(isotropic(-2 * std::log(h)), f.values.data() + 6 * i);
  }
  return f;
}

FieldSlice finite(FieldSlice f) {
  for (std::size_t i = 0; i < f.values.size(); ++i) {
    if (std::isfinite(f.values[i])) continue;
    throw Error(ExitCode::kInput, fmt::format("{}: the value at vertex {} is not finite", f.path,
                                              f.first + static_cast<std::int64_t>(i) + 1));
  }
  return f;
}

/// Clamps the sizes of the metric at the vertices.
void clamp_metric(DistMesh& dist, const MetricOptions& o) {
  if (o.h_min <= 0 && o.h_max >= 1e300) return;
  const double low = -2 * std::log(o.h_max), high = o.h_min > 0 ? -2 * std::log(o.h_min) : 1e300;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    SymTensor& l = dist.mesh.log_metric[v];
    Eigen e = eigen(l);
    for (double& value : e.value) value = std::clamp(value, low, high);
    l = compose(e);
  }
}

GradationReport grade_isotropic(const Comm& comm, DistMesh& dist, double growth) {
  std::vector<double> size(dist.mesh.vert_slots());
  for (const VertId v : IdRange<VertId>(size.size())) size[idx(v)] = std::exp(-0.5 * dist.mesh.log_metric[v].xx);
  const std::vector<double> before = size;
  const GradationReport report = grade_sizes(comm, dist, Halo(comm, dist.sharing), growth, size);
  for (const VertId v : IdRange<VertId>(size.size())) {
    if (size[idx(v)] < before[idx(v)]) dist.mesh.log_metric[v] = isotropic(-2 * std::log(size[idx(v)]));
  }
  return report;
}

GradationReport grade_tensors(const Comm& comm, DistMesh& dist, double growth) {
  std::vector<SymTensor> metric(dist.mesh.vert_slots());
  for (const VertId v : IdRange<VertId>(metric.size())) metric[idx(v)] = exp(dist.mesh.log_metric[v]);
  const std::vector<SymTensor> before = metric;
  const GradationReport report = grade_metric(comm, dist, growth, metric);
  for (const VertId v : IdRange<VertId>(metric.size())) {
    if (metric[idx(v)] != before[idx(v)]) dist.mesh.log_metric[v] = log(metric[idx(v)]);
  }
  return report;
}

/// Collective. Grades the metric at the vertices; nothing without o.gradation.
GradationReport grade(const Comm& comm, DistMesh& dist, const MetricOptions& o) {
  if (o.gradation == 0) return {};
  return o.size.empty() ? grade_tensors(comm, dist, o.gradation) : grade_isotropic(comm, dist, o.gradation);
}

/// Collective. Calls make(c), which sets log_metric to a metric of complexity c and grades it, until what the gradation
/// adds is made up for and the complexity is o.complexity (secants of its logarithm over that of c).
template <class Make>
GradationReport meet_complexity(const Comm& comm, DistMesh& dist, const MetricOptions& o, Make&& make) {
  const double wanted = std::log(o.complexity);
  double aim = wanted, last_aim = 0, last = 0, slope = 1;
  GradationReport report = make(o.complexity);
  for (int i = 0; i < kMostScalings && o.gradation > 0; ++i) {
    const double now = std::log(complexity(comm, dist));
    if (std::abs(now - wanted) < kComplexityTolerance) break;
    if (i > 0) {
      if (std::abs(now - last) < 1e-9) break;  // bounds of the sizes put it out of reach
      slope = std::clamp((now - last) / (aim - last_aim), 0.2, 2.0);
    }
    last = now;
    last_aim = aim;
    aim += (wanted - now) / slope;
    report = make(std::exp(aim));
  }
  return report;
}

/// Collective. Scales the metric at the vertices to o.complexity (if given) and grades it, then clamps its sizes.
GradationReport scale_metric(const Comm& comm, DistMesh& dist, const MetricOptions& o) {
  GradationReport report;
  if (o.complexity > 0) {
    const double now = complexity(comm, dist);
    agree(comm, [&] {
      if (!(now > 0) || !std::isfinite(now)) {
        throw Error(ExitCode::kInput, fmt::format("{}: its complexity is {}; it cannot be scaled", o.path(), now));
      }
    });
    const IdVector<VertId, SymTensor> given = dist.mesh.log_metric;
    double shift = 0;  // of the diagonal of the logarithm
    const auto scaled = [&] {
      dist.mesh.log_metric = given;
      for (SymTensor& l : dist.mesh.log_metric) l.xx += shift, l.yy += shift, l.zz += shift;
    };
    report = meet_complexity(comm, dist, o, [&](double aim) {
      shift = 2.0 / 3 * std::log(aim / now);
      scaled();
      return grade(comm, dist, o);
    });
    if (o.h_min <= 0 && o.h_max >= 1e300) return report;
    scaled();  // clamped before it is graded, so that sizes below the least do not spread
  }
  clamp_metric(dist, o);
  return grade(comm, dist, o);
}

/// Collective. The column `fields` is a scalar; the logarithm of the metric of its second derivatives takes its place.
GradationReport metric_of_field(const Comm& comm, DistMesh& dist, const MetricOptions& o) {
  std::vector<SymTensor> metric(dist.mesh.vert_slots());
  const std::vector<SymTensor> hessian = recover_hessian(comm, dist, Halo(comm, dist.sharing), dist.mesh.fields.values);
  dist.mesh.fields = {};
  dist.mesh.log_metric.assign(metric.size(), {});
  return meet_complexity(comm, dist, o, [&](double aim) {
    hessian_metric(comm, dist, aim, o.norm, o.h_min, o.h_max, hessian, metric);
    for (const VertId v : IdRange<VertId>(metric.size())) dist.mesh.log_metric[v] = log(metric[idx(v)]);
    return grade(comm, dist, o);
  });
}

}  // namespace

void add_metric_options(CLI::App& verb, MetricOptions& o) {
  auto* metric = verb.add_option("--metric", o.metric, "metric: a symmetric tensor per vertex (.sol, .solb)");
  auto* size = verb.add_option("--size", o.size, "wanted edge length per vertex (.sol, .solb)");
  metric->excludes(size);
  verb.add_option("--complexity", o.complexity, "scale the metric to this complexity; about 10 tetrahedra per unit")
      ->check(CLI::PositiveNumber);
}

FieldSlice read_metric(const Comm& comm, const MeshSlice& mesh, const MetricOptions& o) {
  FieldSlice f = read_fields(comm, o.path());
  agree(comm, [&] {
    require_fit(f, mesh, o);
    if (!o.metric.empty()) {
      f = log_of_tensors(std::move(f));
    } else if (!o.size.empty()) {
      f = log_of_sizes(f);
    } else {
      f = finite(std::move(f));
    }
  });
  return f;
}

GradationReport make_metric(const Comm& comm, DistMesh& dist, const MetricOptions& o) {
  return o.field.empty() ? scale_metric(comm, dist, o) : metric_of_field(comm, dist, o);
}

}  // namespace skein::app
