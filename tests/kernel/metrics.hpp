// Smooth random metrics.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "metric/mesh_metric.hpp"
#include "tests/metric/tensors.hpp"

namespace skein::test {

/// Sizes h_i(x) = h exp(a_i . x) along a frame that turns about an axis with x.
struct SmoothMetric {
  std::array<double, 3> size{0.3, 0.3, 0.3};
  std::array<Vec3, 3> slope;
  std::array<Vec3, 3> frame{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 turn;  ///< radians per length

  [[nodiscard]] SymTensor log_at(Vec3 x) const noexcept {
    const double angle = dot(turn, x), c = std::cos(angle), s = std::sin(angle);
    Eigen e;
    e.vector = {c * frame[0] + s * frame[1], c * frame[1] - s * frame[0], frame[2]};
    for (std::size_t i = 0; i < 3; ++i) e.value[i] = -2 * (std::log(size[i]) + dot(slope[i], x));
    return compose(e);
  }
};

/// Sizes between low and high, up to a factor of e^gradient across the unit cube.
inline SmoothMetric random_smooth_metric(std::mt19937& random, double low, double high, double gradient) {
  std::uniform_real_distribution<double> any(0, 1);
  SmoothMetric m;
  for (auto& h : m.size) h = low * std::pow(high / low, any(random));
  for (auto& s : m.slope) s = (2 * gradient * (any(random) - 0.5)) * random_frame(random)[0];
  m.frame = random_frame(random);
  m.turn = (2 * any(random)) * random_frame(random)[0];
  return m;
}

/// Gives the vertices this metric.
template <class Metric>
void set_metric(VertColumns& mesh, const Metric& metric) {
  mesh.log_metric.resize(mesh.coords.size());
  mesh.metric.resize(mesh.coords.size());
  for (const VertId v : IdRange<VertId>(mesh.coords.size())) set_log_metric(mesh, v, metric.log_at(mesh.coords[v]));
}
/// The same size h everywhere.
struct UniformMetric {
  double h;
  [[nodiscard]] SymTensor log_at(Vec3) const noexcept { return log(isotropic(1 / (h * h))); }
};

}  // namespace skein::test
