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

namespace skein {
namespace {

constexpr int kMostScalings = 10;
constexpr double kComplexityTolerance = 1e-3;  ///< of its logarithm
constexpr double kRoundedZero = 1e-14;         ///< eigenvalues this small against the largest may be negative zeros
constexpr double kLogOfNoLimit = -700;         ///< of an eigenvalue of zero: a size of 1e152
constexpr double kLargestSize = 1e3;           ///< in diagonals of the mesh
constexpr double kSmallestSize = 1e-100;

void put(const SymTensor& l, double* out) noexcept {
  out[0] = l.xx, out[1] = l.xy, out[2] = l.yy, out[3] = l.xz, out[4] = l.yz, out[5] = l.zz;
}

/// The logarithm of the metric with this edge length in all directions.
SymTensor log_of_size(double h) noexcept { return isotropic(-2 * std::log(h)); }

/// For messages.
std::int64_t vertex_number(const FieldSlice& f, std::size_t i) noexcept {
  return f.first + static_cast<std::int64_t>(i) + f.first_number;
}

SymTensor checked_log(const SymTensor& m, const FieldSlice& f, std::size_t i) {
  if (!is_finite(m)) {
    throw Error(ExitCode::kInput,
                fmt::format("{}: the metric at vertex {} is not finite", f.path, vertex_number(f, i)));
  }
  if (!is_positive_definite(m)) {
    Eigen e = eigen(m);
    if (e.value[0] >= -kRoundedZero * std::max(e.value[2], 0.0)) {
      for (double& value : e.value) value = value > 0 ? std::log(value) : kLogOfNoLimit;
      return compose(e);
    }
    throw Error(ExitCode::kInput,
                fmt::format("{}: the metric at vertex {} is not positive: eigenvalues {:.6g}, {:.6g}, {:.6g}", f.path,
                            vertex_number(f, i), e.value[0], e.value[1], e.value[2]));
  }
  return log(m);
}

FieldSlice log_of_tensors(FieldSlice f) {
  for (std::size_t i = 0; i < f.values.size() / 6; ++i) {
    double* v = f.values.data() + 6 * i;
    put(checked_log({v[0], v[1], v[2], v[3], v[4], v[5]}, f, i), v);
  }
  return f;
}

FieldSlice log_of_sizes(const FieldSlice& sizes) {
  FieldSlice f;
  f.path = sizes.path, f.first_number = sizes.first_number, f.total = sizes.total, f.first = sizes.first;
  f.kinds = {FieldKind::kTensor}, f.width = 6;
  f.values.resize(6 * sizes.values.size());
  for (std::size_t i = 0; i < sizes.values.size(); ++i) {
    const double h = sizes.values[i];
    if (!(h > 0) || !std::isfinite(h)) {
      throw Error(ExitCode::kInput, fmt::format("{}: the size at vertex {} is {:.6g}; sizes must be greater than zero",
                                                f.path, vertex_number(f, i), h));
    }
    put(log_of_size(h), f.values.data() + 6 * i);
  }
  return f;
}

FieldSlice finite(FieldSlice f) {
  for (std::size_t i = 0; i < f.values.size(); ++i) {
    if (std::isfinite(f.values[i])) continue;
    throw Error(ExitCode::kInput, fmt::format("{}: the value at vertex {} is not finite", f.path, vertex_number(f, i)));
  }
  return f;
}

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

/// Collective. Calls make(c), which makes log_metric one of complexity c and grades it, until what the gradation adds
/// is made up for and the complexity is the policy's (secants of its logarithm over that of c).
template <class Make>
GradationReport meet_complexity(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                std::span<const SymTensor> log_metric, Make&& make) {
  const double wanted = std::log(policy.complexity);
  double aim = wanted, last_aim = 0, last = 0, slope = 1;
  GradationReport report = make(policy.complexity);
  for (int i = 0; i < kMostScalings && policy.gradation > 0; ++i) {
    const double now = std::log(complexity_from_log(comm, dist, log_metric));
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

}  // namespace

FieldSlice metric_values(FieldSlice given, MetricSource source) {
  switch (source) {
    case MetricSource::kTensors:
      return log_of_tensors(std::move(given));
    case MetricSource::kSizes:
      return log_of_sizes(given);
    case MetricSource::kField:
      return finite(std::move(given));
  }
  return given;
}

double complexity_from_log(const Comm& comm, const DistMesh& dist, std::span<const SymTensor> log_metric) {
  IdVector<VertId, double> sqrt_det(log_metric.size());
  for (const VertId v : IdRange<VertId>(sqrt_det.size())) sqrt_det[v] = std::exp(log_sqrt_det(log_metric[idx(v)]));
  return comm.sum(complexity_of(dist.mesh, [&](VertId v) { return sqrt_det[v]; }));
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

GradationReport scale_to_complexity(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                    std::span<SymTensor> log_metric) {
  const double now = complexity_from_log(comm, dist, log_metric);
  agree(comm, [&] {
    if (!(now > 0) || !std::isfinite(now)) {
      throw Error(ExitCode::kInput, fmt::format("{}: its complexity is {}; it cannot be scaled", policy.name, now));
    }
  });
  const std::vector<SymTensor> given(log_metric.begin(), log_metric.end());
  double factor = 1;
  const auto scale = [&] {
    std::copy(given.begin(), given.end(), log_metric.begin());
    scale_complexity(factor, log_metric);
  };
  const GradationReport report = meet_complexity(comm, dist, policy, log_metric, [&](double aim) {
    factor = aim / now;
    scale();
    return grade(comm, dist, policy, log_metric);
  });
  if (!policy.clamps()) return report;
  scale();  // clamped before it is graded, so that sizes below the least do not spread
  clamp_sizes(policy, log_metric);
  return grade(comm, dist, policy, log_metric);
}

GradationReport metric_from_field(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                  std::span<const double> scalar, std::span<SymTensor> log_metric) {
  const std::vector<SymTensor> hessian = recover_hessian(comm, dist, Halo(comm, dist.sharing), scalar);
  std::vector<SymTensor> metric(hessian.size());
  return meet_complexity(comm, dist, policy, log_metric, [&](double aim) {
    hessian_metric(comm, dist, aim, policy.norm, policy.h_min, policy.h_max, hessian, metric);
    std::transform(metric.begin(), metric.end(), log_metric.begin(), [](const SymTensor& m) { return log(m); });
    return grade(comm, dist, policy, log_metric);
  });
}

GradationReport make_metric(const Comm& comm, DistMesh& dist, const MetricPolicy& policy) {
  auto& column = dist.mesh.log_metric;
  if (policy.source == MetricSource::kField) {
    const VertFields scalar = std::exchange(dist.mesh.fields, {});
    column.assign(dist.mesh.vert_slots(), {});
    return metric_from_field(comm, dist, policy, scalar.values, column.raw());
  }
  bound_sizes(comm, dist, policy, column.raw());
  if (policy.complexity > 0) return scale_to_complexity(comm, dist, policy, column.raw());
  clamp_sizes(policy, column.raw());
  return grade(comm, dist, policy, column.raw());
}

}  // namespace skein
