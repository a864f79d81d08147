// How the metric to adapt to is made of what is given: tensors, sizes, or a solution whose Hessian makes it; scaled to
// a complexity, its sizes bounded and graded.
//
// Functions that take `log_metric` want the logarithm of the metric, one tensor per local vertex, equal on all copies
// of a vertex; so is what they give.
#pragma once
#include <span>
#include <string>

#include "base/tensor.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "metric/spacing.hpp"
#include "solution/gradation.hpp"
#include "solution/local_sizes.hpp"
#include "solution/metric_values.hpp"

namespace skein {

inline constexpr double kNoLargestSize = 1e300;

struct MetricPolicy {
  MetricSource source = MetricSource::kTensors;
  double complexity = 0;                     ///< that the metric shall have; 0: as it is (not with kField)
  double h_min = 0, h_max = kNoLargestSize;  ///< length; these clamp the sizes
  double norm = 2;                           ///< with kField: L^p of the interpolation error, p >= 1 or infinity
  double aspect_max = 0;                     ///< largest over smallest size at a vertex, >= 1; 0: any
  double gradation = 0;                      ///< largest growth of sizes from edge to edge, > 1; 0: as they are
  double max_tets = 0;                       ///< refuse a metric that asks for more; 0: for more than memory allows
  std::string name = "the metric";           ///< of what is given, for messages: the path of a file
  SpacingField sources = {};                 ///< no size shall be above its own
  std::vector<LocalRule> local = {};         ///< by patch and region; before all other bounds
  [[nodiscard]] bool clamps() const noexcept { return h_min > 0 || h_max < kNoLargestSize; }
  [[nodiscard]] bool has_sources() const noexcept {
    return !sources.sources.empty() || sources.size_max < kNoLargestSize;
  }
  [[nodiscard]] FieldKind kind() const noexcept {
    return source == MetricSource::kTensors ? FieldKind::kTensor : FieldKind::kScalar;
  }
};

/// What became of the policy.
struct MetricReport : GradationReport {
  double complexity = 0;  ///< of the metric; policy.complexity where that was wanted and the bounds allow it
};

/// Collective. The integral of sqrt(det M) over all ranks' tetrahedra, with log M linear in each, as the adaptation
/// interpolates it.
double complexity_from_log(const Comm& comm, const DistMesh& dist, std::span<const SymTensor> log_metric);

/// M <- factor^(2/3) M, which makes the complexity `factor` times as large. @pre factor > 0
void scale_complexity(double factor, std::span<SymTensor> log_metric) noexcept;

/// The eigenvalues of M clamped to [1/h_max^2, 1/h_min^2]; h_min may be 0. Nothing happens without policy.clamps().
void clamp_sizes(const MetricPolicy& policy, std::span<SymTensor> log_metric) noexcept;

/// The smallest eigenvalues of M raised until the largest size is `most` times the smallest. @pre most >= 1
void clamp_aspect(double most, std::span<SymTensor> log_metric) noexcept;

/// Collective. Bounds the growth of sizes (grade_sizes() for kSizes, grade_metric() for others). Vertices that are not
/// lowered keep their bits. Nothing happens for a gradation of 0.
GradationReport grade(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                      std::span<SymTensor> log_metric);

/// Collective. Scales the metric such that with its bounds (sizes, aspect ratio, sources, local rules) and its
/// gradation it has policy.complexity, to 0.1 %, or what the bounds allow that is nearest. Bounds come before the
/// gradation, so that sizes below the least do not spread. Graded sizes keep the bounds; intersections of tensors that
/// are turned against each other may go below h_min. Throws Error(kInput) on all ranks when its complexity is zero or
/// not finite.
/// @pre policy.complexity > 0
MetricReport scale_to_complexity(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                 std::span<SymTensor> log_metric);

/// Collective. scale_complexity() of the column log_metric, and the bounds of the policy again; no gradation.
void rescale(const Comm& comm, DistMesh& dist, const MetricPolicy& policy, double factor);

/// Collective. The metric of the second derivatives of solutions (hessian_metric()), of several the strictest: with
/// bounds and gradation as for scale_to_complexity(). scalar: n values per local vertex, equal on all copies.
MetricReport metric_from_field(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                               std::span<const double> scalar, std::span<SymTensor> log_metric);

/// Collective. Sizes of more than 1e3 times the diagonal of the mesh, in any direction, become that: they are no limit.
/// Throws Error(kInput) on all ranks with the vertex for a size below 1e-100 diagonals.
void bound_sizes(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy, std::span<SymTensor> log_metric);

/// Collective. The whole policy: what metric_values() gave, in the column log_metric (kTensors, kSizes) or `fields`
/// (kField), or the mesh itself (kMesh), becomes the logarithm of the metric to adapt to in log_metric: scaled to the
/// complexity (if there is one), bounded, graded.
MetricReport make_metric(const Comm& comm, DistMesh& dist, const MetricPolicy& policy);

}  // namespace skein
