// MetricField: the metric at the vertices of a mesh, with its logarithm for interpolation.
#pragma once
#include "mesh/ids.hpp"
#include "metric/measure.hpp"
#include "metric/tensor.hpp"

namespace skein {

/// The metric at every vertex, twice: as it measures (with determinant) and as it is interpolated (log-Euclidean).
struct MetricField {
  IdVector<VertId, VertMetric> at;
  IdVector<VertId, SymTensor> log_at;

  [[nodiscard]] std::size_t size() const noexcept { return at.size(); }
  /// Appends a vertex whose metric has this logarithm.
  void push_back_log(const SymTensor& log_m) {
    log_at.push_back(log_m);
    at.push_back(vert_metric(exp(log_m)));
  }
  void set_log(VertId v, const SymTensor& log_m) {
    log_at[v] = log_m;
    at[v] = vert_metric(exp(log_m));
  }
};

/// Length of the edge between two vertices at xa and xb.
inline double edge_length(const MetricField& f, VertId a, VertId b, Vec3 xa, Vec3 xb) noexcept {
  return edge_length(f.at[a].m, f.at[b].m, xb - xa);
}

}  // namespace skein
