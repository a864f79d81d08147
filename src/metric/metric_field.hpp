// MetricField: the metric at the vertices of a mesh, with its logarithm for interpolation.
#pragma once
#include "base/ids.hpp"
#include "metric/batch.hpp"
#include "metric/measure.hpp"
#include "metric/tensor.hpp"

namespace skein {

/// exp(log_m), with sqrt(det) from the trace: see log_sqrt_det().
inline VertMetric vert_metric_from_log(const SymTensor& log_m) noexcept {
  const SymTensor m = exp(log_m);
  const double sqrt_det = std::exp(log_sqrt_det(log_m));
  return {m, sqrt_det, order_key_of(m, sqrt_det)};
}

/// The metric at every vertex, twice: as it measures (with determinant) and as it is interpolated (log-Euclidean).
struct MetricField {
  IdVector<VertId, VertMetric> at;
  IdVector<VertId, SymTensor> log_at;

  [[nodiscard]] std::size_t size() const noexcept { return at.size(); }
  void reserve(std::size_t n) {
    at.reserve(n);
    log_at.reserve(n);
  }
  /// Appends a vertex whose metric has this logarithm.
  void push_back_log(const SymTensor& log_m) {
    log_at.push_back(log_m);
    at.push_back(vert_metric_from_log(log_m));
  }
  void set_log(VertId v, const SymTensor& log_m) {
    log_at[v] = log_m;
    at[v] = vert_metric_from_log(log_m);
  }
  /// Vertex `to` gets the metric that vertex `from` of the other field has.
  void copy(const MetricField& other, VertId from, VertId to) {
    at[to] = other.at[from];
    log_at[to] = other.log_at[from];
  }
  /// What set_log does, to rounding, for many vertices from `first` on whose logarithms are there.
  void measure(VertId first, std::size_t n) noexcept {
    vert_metrics_from_logs(
        idx(first), idx(first) + n, [&](std::size_t i) -> const SymTensor& { return log_at[to_id<VertId>(i)]; },
        [&](std::size_t i, const VertMetric& m) { at[to_id<VertId>(i)] = m; });
  }
};

/// Length of the edge between two vertices at xa and xb.
inline double edge_length(const MetricField& f, VertId a, VertId b, Vec3 xa, Vec3 xb) noexcept {
  return edge_length(f.at[a].m, f.at[b].m, xb - xa);
}

}  // namespace skein
