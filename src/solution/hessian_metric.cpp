// Absolute Hessian, L^p weight, and the scale that meets the complexity under clamps.
#include "solution/hessian_metric.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "metric/complexity.hpp"

namespace skein {
namespace {

/// Eigenvalues are clamped to [low, high] after scaling.
struct Bounds {
  double low, high;
  [[nodiscard]] double clamp(double x) const noexcept { return std::min(std::max(x, low), high); }
};

/// Complexity of the metric with eigenvalues clamp(scale * value).
double clamped_complexity(const Comm& comm, const std::vector<double>& weight, const std::vector<Eigen>& eigen,
                          const Bounds& bounds, double scale) {
  double sum = 0;
  for (std::size_t i = 0; i < eigen.size(); ++i) {
    double root = weight[i];
    for (const double value : eigen[i].value) root *= std::sqrt(bounds.clamp(scale * value));
    sum += root;
  }
  return comm.sum(sum);
}

/// The scale whose clamped complexity is the target. The complexity rises with the scale, so bisection in its
/// logarithm.
double find_scale(const Comm& comm, const std::vector<double>& weight, const std::vector<Eigen>& eigen,
                  const Bounds& bounds, double target) {
  const auto at = [&](double scale) { return clamped_complexity(comm, weight, eigen, bounds, scale); };
  const double free = clamped_complexity(comm, weight, eigen, {0, std::numeric_limits<double>::infinity()}, 1);
  double low = std::pow(target / free, 2.0 / 3), high = low;
  // The brackets grow fast and stop at a span that no clamp of practice needs: beyond, the bounds decide alone.
  for (double step = 4; at(low) > target && step < 1e40; step *= step) low /= step;
  for (double step = 4; at(high) < target && step < 1e40; step *= step) high *= step;
  for (int i = 0; i < 200 && high > low * (1 + 1e-13); ++i) {
    const double middle = std::sqrt(low) * std::sqrt(high), reached = at(middle);
    if (std::abs(reached - target) <= 1e-12 * target) return middle;
    (reached < target ? low : high) = middle;
  }
  return std::sqrt(low) * std::sqrt(high);
}

void check(const Comm& comm, const DistMesh& dist, double complexity, double p, double h_min, double h_max,
           std::span<const SymTensor> hessian, double max_aspect) {
  agree(comm, [&] {
    const auto refuse = [](const std::string& line) { throw Error(ExitCode::kInput, line); };
    if (!(complexity > 0) || std::isinf(complexity))
      refuse(fmt::format("complexity is {}; it must be positive", complexity));
    if (!(p >= 1)) refuse(fmt::format("the norm p is {}; it must be 1 or more", p));
    if (!(h_min >= 0) || !(h_max > 0) || !(h_min <= h_max))
      refuse(fmt::format("sizes from {} to {}; the smallest must be positive and below the largest", h_min, h_max));
    if (!(max_aspect >= 1)) refuse(fmt::format("the largest aspect ratio is {}; it must be 1 or more", max_aspect));
    for (const VertId v : IdRange<VertId>(hessian.size())) {
      if (!is_finite(hessian[idx(v)]))
        refuse(fmt::format("the Hessian is not finite at vertex {}", num(dist.vert2gid[v]) + 1));
    }
  });
}

/// |H| with its eigenvalues kept within the aspect ratio and above a floor, times det^(-1/(2p+3)).
std::vector<Eigen> weighted_hessian(const Comm& comm, std::span<const SymTensor> hessian, double p, double max_aspect) {
  std::vector<Eigen> all(hessian.size());
  double largest = 0;
  for (std::size_t i = 0; i < hessian.size(); ++i) {
    all[i] = eigen(hessian[i]);
    for (double& value : all[i].value) largest = std::max(largest, value = std::abs(value));
  }
  largest = comm.max(largest);
  // Relative to the largest, so that the unit of the solution does not matter; a constant solution becomes uniform.
  constexpr double kFloor = 1e-16;
  const double exponent = std::isinf(p) ? 0 : -1 / (2 * p + 3);
  for (Eigen& e : all) {
    for (double& value : e.value) value = largest > 0 ? std::max(value / largest, kFloor) : 1;
    const double top = std::max({e.value[0], e.value[1], e.value[2]});
    for (double& value : e.value) value = std::max(value, top / (max_aspect * max_aspect));
    const double factor = std::pow(e.value[0] * e.value[1] * e.value[2], exponent);
    for (double& value : e.value) value *= factor;
  }
  return all;
}

}  // namespace

double hessian_metric(const Comm& comm, const DistMesh& dist, double complexity, double p, double h_min, double h_max,
                      std::span<const SymTensor> hessian, std::span<SymTensor> metric, double max_aspect) {
  check(comm, dist, complexity, p, h_min, h_max, hessian, max_aspect);
  auto eigen = weighted_hessian(comm, hessian, p, max_aspect);
  const auto weight = vertex_rule_weights(dist.mesh);
  const Bounds bounds{1 / (h_max * h_max), h_min > 0 ? 1 / (h_min * h_min) : std::numeric_limits<double>::infinity()};
  const double scale = find_scale(comm, weight, eigen, bounds, complexity);
  for (std::size_t i = 0; i < eigen.size(); ++i) {
    for (double& value : eigen[i].value) value = bounds.clamp(scale * value);
    metric[i] = compose(eigen[i]);
  }
  return clamped_complexity(comm, weight, eigen, {0, std::numeric_limits<double>::infinity()}, 1);
}

}  // namespace skein
