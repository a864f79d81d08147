// Many tensors at once: eight in the lanes of the vector unit.
#pragma once
#include <array>
#include <cstddef>

#include "base/tensor.hpp"
#include "metric/measure.hpp"

namespace skein {

constexpr std::size_t kTensorLanes = 8;
/// The same component of eight tensors; the six of a tensor in Medit order.
using TensorLanes = std::array<std::array<double, kTensorLanes>, 6>;

/// vert_metric_from_log of eight logarithms, to rounding. What comes out of a lane depends on nothing but what went
/// into it. @pre all are finite.
void vert_metrics_from_logs(const TensorLanes& log_m, std::array<VertMetric, kTensorLanes>& out) noexcept;

/// The same for n logarithms, log_at(i) for i = first .. last-1; store(i, metric) takes what comes out.
template <class LogAt, class Store>
void vert_metrics_from_logs(std::size_t first, std::size_t last, LogAt&& log_at, Store&& store) {
  TensorLanes lanes{};
  std::array<VertMetric, kTensorLanes> out;
  for (std::size_t i = first; i < last; i += kTensorLanes) {
    const std::size_t n = last - i < kTensorLanes ? last - i : kTensorLanes;
    for (std::size_t l = 0; l < n; ++l) {
      const SymTensor& t = log_at(i + l);
      lanes[0][l] = t.xx, lanes[1][l] = t.xy, lanes[2][l] = t.yy;
      lanes[3][l] = t.xz, lanes[4][l] = t.yz, lanes[5][l] = t.zz;
    }
    vert_metrics_from_logs(lanes, out);
    for (std::size_t l = 0; l < n; ++l) store(i + l, out[l]);
  }
}

}  // namespace skein
