// The metric at the vertices of a mesh: what measures (column `metric`), made from its logarithm (column `log_metric`).
#pragma once
#include <cmath>

#include "base/ids.hpp"
#include "base/tensor.hpp"
#include "mesh/vert_columns.hpp"
#include "metric/batch.hpp"
#include "metric/measure.hpp"

namespace skein {

/// exp(log_m), with sqrt(det) from the trace: see log_sqrt_det().
inline VertMetric vert_metric_from_log(const SymTensor& log_m) noexcept {
  const SymTensor m = exp(log_m);
  const double sqrt_det = std::exp(log_sqrt_det(log_m));
  return {m, sqrt_det, order_key_of(m, sqrt_det)};
}

/// Gives vertex v the metric with this logarithm. @pre both columns are there
inline void set_log_metric(VertColumns& mesh, VertId v, const SymTensor& log_m) noexcept {
  mesh.log_metric[v] = log_m;
  mesh.metric[v] = vert_metric_from_log(log_m);
}

/// What set_log_metric does, to rounding, for n vertices from `first` on whose logarithms are there.
inline void measure_metric(VertColumns& mesh, VertId first, std::size_t n) noexcept {
  vert_metrics_from_logs(
      idx(first), idx(first) + n, [&](std::size_t i) -> const SymTensor& { return mesh.log_metric[to_id<VertId>(i)]; },
      [&](std::size_t i, const VertMetric& m) { mesh.metric[to_id<VertId>(i)] = m; });
}
/// Makes the column `metric` from `log_metric`.
inline void measure_metric(VertColumns& mesh) {
  mesh.metric.resize(mesh.log_metric.size());
  measure_metric(mesh, VertId{0}, mesh.log_metric.size());
}

}  // namespace skein
