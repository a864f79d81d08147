// Secants to the complexity, clamps and gradation of a log-metric.
#include "solution/metric_policy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/box.hpp"
#include "metric/complexity.hpp"
#include "solution/hessian.hpp"
#include "solution/hessian_metric.hpp"
#include "solution/own_metric.hpp"

namespace skein {
namespace {

constexpr int kMostScalings = 10;
constexpr double kComplexityTolerance = 1e-3;  ///< of its logarithm
constexpr double kLargestSize = 1e3;           ///< in diagonals of the mesh
constexpr double kSmallestSize = 1e-100;

/// The logarithm of the metric with this edge length in all directions.
SymTensor log_of_size(double h) noexcept { return isotropic(-2 * std::log(h)); }

GradationReport grade_isotropic(const Comm& comm, const DistMesh& dist, double growth,
                                std::span<SymTensor> log_metric) {
  std::vector<double> size(log_metric.size());
  for (std::size_t v = 0; v < size.size(); ++v) size[v] = std::exp(-0.5 * log_metric[v].xx);
  const std::vector<double> before = size;
  const GradationReport report = grade_sizes(comm, dist, Halo(comm, dist.sharing), growth, size);
  for (std::size_t v = 0; v < size.size(); ++v) {
    if (size[v] < before[v]) log_metric[v] = log_of_size(size[v]);
  }
  return report;
}

GradationReport grade_tensors(const Comm& comm, const DistMesh& dist, double growth, std::span<SymTensor> log_metric) {
  std::vector<SymTensor> metric(log_metric.size());
  for (std::size_t v = 0; v < metric.size(); ++v) metric[v] = exp(log_metric[v]);
  const std::vector<SymTensor> before = metric;
  const GradationReport report = grade_metric(comm, dist, growth, metric);
  for (std::size_t v = 0; v < metric.size(); ++v) {
    if (metric[v] != before[v]) log_metric[v] = log(metric[v]);
  }
  return report;
}

/// Collective. Of the box round all vertices.
double global_diagonal(const Comm& comm, const TetMesh& mesh) {
  const Box own = bounding_box(mesh.coords.raw());
  std::array<double, 6> ends{own.low.x, own.low.y, own.low.z, -own.high.x, -own.high.y, -own.high.z};
  comm.reduce(std::span<double>(ends), Op::kMin);
  return norm(Vec3{ends[0] + ends[3], ends[1] + ends[4], ends[2] + ends[5]});
}

/// What bounds the sizes, whatever they are scaled to.
class Bounds {
 public:
  /// Collective.
  Bounds(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy)
      : policy_(policy), local_(comm, dist, policy.local) {
    if (!policy.has_sources()) return;
    for (const Vec3 x : dist.mesh.coords) source_.push_back(-2 * std::log(policy.sources.at(x)));
  }
  void apply(std::span<SymTensor> log_metric) const {
    clamp_sizes(policy_, log_metric);
    if (policy_.aspect_max > 0) clamp_aspect(policy_.aspect_max, log_metric);
    local_.apply(log_metric);
    for (std::size_t v = 0; v < source_.size(); ++v) log_metric[v] = at_least(log_metric[v], source_[v]);
  }

 private:
  const MetricPolicy& policy_;
  LocalBounds local_;
  std::vector<double> source_;  // per vertex: least eigenvalue of log M; empty: no sources
};

/// Collective. Calls make(c), which makes log_metric one of complexity c, bounds and grades it, until the complexity is
/// the policy's with all that (secants of its logarithm over that of c).
template <class Make>
MetricReport meet_complexity(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                             std::span<const SymTensor> log_metric, Make&& make) {
  const double wanted = std::log(policy.complexity);
  double aim = wanted, last_aim = 0, last = 0, slope = 1;
  MetricReport report{make(policy.complexity)};
  for (int i = 0;; ++i) {
    report.complexity = complexity_from_log(comm, dist, log_metric);
    const double now = std::log(report.complexity);
    if (std::abs(now - wanted) < kComplexityTolerance || i == kMostScalings) return report;
    if (i > 0) {
      if (std::abs(now - last) < 1e-9) return report;  // bounds of the sizes put it out of reach
      slope = std::clamp((now - last) / (aim - last_aim), 0.2, 2.0);
    }
    last = now;
    last_aim = aim;
    aim += (wanted - now) / slope;
    static_cast<GradationReport&>(report) = make(std::exp(aim));
  }
}

/// The k-th of n numbers at each vertex.
std::vector<double> component(std::span<const double> values, std::size_t n, std::size_t k) {
  std::vector<double> out(values.size() / n);
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = values[v * n + k];
  return out;
}

}  // namespace

double complexity_from_log(const Comm& comm, const DistMesh& dist, std::span<const SymTensor> log_metric) {
  return comm.sum(complexity_of_log(dist.mesh, [&](VertId v) { return log_sqrt_det(log_metric[idx(v)]); }));
}

void scale_complexity(double factor, std::span<SymTensor> log_metric) noexcept {
  const double shift = 2.0 / 3 * std::log(factor);
  for (SymTensor& l : log_metric) l.xx += shift, l.yy += shift, l.zz += shift;
}

void clamp_sizes(const MetricPolicy& policy, std::span<SymTensor> log_metric) noexcept {
  if (!policy.clamps()) return;
  const double low = -2 * std::log(policy.h_max), high = policy.h_min > 0 ? -2 * std::log(policy.h_min) : 1e300;
  for (SymTensor& l : log_metric) {
    Eigen e = eigen(l);
    for (double& value : e.value) value = std::clamp(value, low, high);
    l = compose(e);
  }
}

void clamp_aspect(double most, std::span<SymTensor> log_metric) noexcept {
  const double span = 2 * std::log(most);
  for (SymTensor& l : log_metric) {
    Eigen e = eigen(l);
    if (e.value[2] - e.value[0] <= span) continue;
    for (double& value : e.value) value = std::max(value, e.value[2] - span);
    l = compose(e);
  }
}

void bound_sizes(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy, std::span<SymTensor> log_metric) {
  const double diagonal = global_diagonal(comm, dist.mesh);
  const double low = -2 * std::log(kLargestSize * diagonal), high = -2 * std::log(kSmallestSize * diagonal);
  agree(comm, [&] {
    for (std::size_t v = 0; v < log_metric.size(); ++v) {
      SymTensor& l = log_metric[v];
      const double turned = std::abs(l.xy) + std::abs(l.xz) + std::abs(l.yz);  // bounds the eigenvalues
      if (std::min({l.xx, l.yy, l.zz}) - turned >= low && std::max({l.xx, l.yy, l.zz}) + turned <= high) continue;
      Eigen e = eigen(l);
      if (e.value[2] > high)
        throw Error(
            ExitCode::kInput,
            fmt::format("{}: the size at vertex {} is {:.3g}, on a mesh of diagonal {:.3g}; give it in the mesh's "
                        "unit of length",
                        policy.name, num(dist.vert2gid[to_id<VertId>(v)]) + 1, std::exp(-0.5 * e.value[2]), diagonal));
      if (e.value[0] >= low) continue;
      for (double& value : e.value) value = std::max(value, low);
      l = compose(e);
    }
  });
}

GradationReport grade(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                      std::span<SymTensor> log_metric) {
  if (policy.gradation == 0) return {};
  return policy.source == MetricSource::kSizes ? grade_isotropic(comm, dist, policy.gradation, log_metric)
                                               : grade_tensors(comm, dist, policy.gradation, log_metric);
}

MetricReport scale_to_complexity(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                 std::span<SymTensor> log_metric) {
  const double now = complexity_from_log(comm, dist, log_metric);
  agree(comm, [&] {
    if (!(now > 0) || !std::isfinite(now)) {
      throw Error(ExitCode::kInput, fmt::format("{}: its complexity is {}; it cannot be scaled", policy.name, now));
    }
  });
  const std::vector<SymTensor> given(log_metric.begin(), log_metric.end());
  const Bounds bounds(comm, dist, policy);
  return meet_complexity(comm, dist, policy, log_metric, [&](double aim) {
    std::copy(given.begin(), given.end(), log_metric.begin());
    scale_complexity(aim / now, log_metric);
    bounds.apply(log_metric);
    return grade(comm, dist, policy, log_metric);
  });
}

void rescale(const Comm& comm, DistMesh& dist, const MetricPolicy& policy, double factor) {
  scale_complexity(factor, dist.mesh.log_metric.raw());
  Bounds(comm, dist, policy).apply(dist.mesh.log_metric.raw());
}

MetricReport metric_from_field(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                               std::span<const double> scalar, std::span<SymTensor> log_metric) {
  constexpr double kMostStretched = 1e4;
  const std::size_t fields = scalar.size() / std::max<std::size_t>(1, log_metric.size());
  const auto n = static_cast<std::size_t>(comm.max(static_cast<std::int64_t>(fields)));
  std::vector<std::vector<SymTensor>> hessian;
  for (std::size_t k = 0; k < n; ++k) {
    hessian.push_back(recover_hessian(comm, dist, Halo(comm, dist.sharing), component(scalar, n, k)));
  }
  std::vector<SymTensor> metric(log_metric.size());
  const Bounds bounds(comm, dist, policy);
  return meet_complexity(comm, dist, policy, log_metric, [&](double aim) {
    for (std::size_t k = 0; k < n; ++k) {
      hessian_metric(comm, dist, aim, policy.norm, policy.h_min, policy.h_max, hessian[k], metric,
                     policy.aspect_max > 0 ? policy.aspect_max : kMostStretched);
      for (std::size_t v = 0; v < metric.size(); ++v) {
        log_metric[v] = k == 0 ? log(metric[v]) : strictest(log_metric[v], log(metric[v]));
      }
    }
    bounds.apply(log_metric);
    return grade(comm, dist, policy, log_metric);
  });
}

MetricReport make_metric(const Comm& comm, DistMesh& dist, const MetricPolicy& policy) {
  auto& column = dist.mesh.log_metric;
  if (policy.source == MetricSource::kField) {
    const VertFields scalar = std::exchange(dist.mesh.fields, {});
    column.assign(dist.mesh.vert_slots(), {});
    return metric_from_field(comm, dist, policy, scalar.values, column.raw());
  }
  if (policy.source == MetricSource::kMesh) column.raw() = own_log_metric(comm, dist);
  bound_sizes(comm, dist, policy, column.raw());
  if (policy.complexity > 0) return scale_to_complexity(comm, dist, policy, column.raw());
  Bounds(comm, dist, policy).apply(column.raw());
  MetricReport report{grade(comm, dist, policy, column.raw())};
  report.complexity = complexity_from_log(comm, dist, column.raw());
  return report;
}

}  // namespace skein
