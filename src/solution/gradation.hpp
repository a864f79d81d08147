// Gradation of sizes and metrics over all ranks (metric/gradation.hpp has the rule).
#pragma once
#include <cstdint>
#include <span>

#include "base/tensor.hpp"
#include "comm/halo.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Result of a gradation, over all ranks.
struct GradationReport {
  std::int64_t lowered = 0;  ///< vertices that became stricter
  int sweeps = 0;            ///< exchanges between the ranks
  bool converged = true;     ///< false: ended at kMostSweeps with the bound still broken somewhere
};
inline constexpr int kMostSweeps = 1000;

/// Collective. Lowers sizes until size(w) <= size(v) + ln(growth) |vw| on every edge, so that a size grows by less than
/// the factor `growth` over its own length. The result is unique: the same bits on any number of ranks. Throws
/// Error(kInput) on all ranks for a size that is not greater than zero, and for growth <= 1. size: one per local vertex
/// (length), equal on all copies, and so is the result. @pre `halo` is that of dist.sharing.
GradationReport grade_sizes(const Comm& comm, const DistMesh& dist, const Halo& halo, double growth,
                            std::span<double> size);

/// Collective. Makes metrics stricter until on every edge vw the metric at w is at least as strict as the metric of v
/// after its growth along the edge, in every direction (is_within: to 0.05 % of the size). Each sweep starts from the
/// metrics before it. At each vertex the metric is intersected with the grown metrics of its neighbours, in the order
/// of their global ids. So the same metric and global ids give the same bits on any number of ranks. Otherwise as
/// grade_sizes().
GradationReport grade_metric(const Comm& comm, const DistMesh& dist, double growth, std::span<SymTensor> metric);

}  // namespace skein
