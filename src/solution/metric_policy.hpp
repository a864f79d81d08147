// How the metric to adapt to is made of what is given: tensors, sizes, or a solution whose Hessian makes it; scaled to
// a complexity, its sizes clamped and graded.
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
#include "solution/gradation.hpp"

namespace skein {

/// What the numbers at the vertices are.
enum class MetricSource {
  kTensors,  ///< metrics: six numbers, symmetric positive definite, 1/length^2
  kSizes,    ///< wanted edge lengths
  kField,    ///< a solution: the metric is that of its second derivatives
};

inline constexpr double kNoLargestSize = 1e300;

struct MetricPolicy {
  MetricSource source = MetricSource::kTensors;
  double complexity = 0;                     ///< that the metric shall have; 0: as it is (not with kField)
  double h_min = 0, h_max = kNoLargestSize;  ///< length; these clamp the sizes
  double norm = 2;                           ///< with kField: L^p of the interpolation error, p >= 1 or infinity
  double gradation = 0;                      ///< largest growth of sizes from edge to edge, > 1; 0: as they are
  double max_tets = 0;                       ///< refuse a metric that asks for more; 0: for more than memory allows
  std::string name = "the metric";           ///< of what is given, for messages: the path of a file
  [[nodiscard]] bool clamps() const noexcept { return h_min > 0 || h_max < kNoLargestSize; }
  [[nodiscard]] FieldKind kind() const noexcept {
    return source == MetricSource::kTensors ? FieldKind::kTensor : FieldKind::kScalar;
  }
};

/// What distribute() takes of values as they are given: the logarithm of the metric for kTensors and kSizes, the scalar
/// itself for kField. Not collective. Throws Error(kInput) with the path of `given` and the number of the vertex for a
/// metric with a negative eigenvalue (with all three), a size that is not greater than zero, and for what is not
/// finite. An eigenvalue of zero is no limit of the size in its direction. @pre one field of kind policy.kind()
FieldSlice metric_values(FieldSlice given, MetricSource source);

/// Collective. The integral of sqrt(det M) over all ranks' tetrahedra, by the vertex rule (metric/complexity.hpp).
double complexity_from_log(const Comm& comm, const DistMesh& dist, std::span<const SymTensor> log_metric);

/// M <- factor^(2/3) M, which makes the complexity `factor` times as large. @pre factor > 0
void scale_complexity(double factor, std::span<SymTensor> log_metric) noexcept;

/// The eigenvalues of M clamped to [1/h_max^2, 1/h_min^2]; h_min may be 0. Nothing happens without policy.clamps().
void clamp_sizes(const MetricPolicy& policy, std::span<SymTensor> log_metric) noexcept;

/// Collective. Bounds the growth of sizes (grade_sizes() for kSizes, grade_metric() for others). Vertices that are not
/// lowered keep their bits. Nothing happens for a gradation of 0.
GradationReport grade(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                      std::span<SymTensor> log_metric);

/// Collective. Scales the metric to policy.complexity such that it has it after its gradation (to 0.1 %), then clamps
/// and grades; the clamped metric may have another complexity. Graded sizes keep the bounds; intersections of tensors
/// that are turned against each other may go below h_min. Throws Error(kInput) on all ranks when its complexity is zero
/// or not finite. @pre policy.complexity > 0
GradationReport scale_to_complexity(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                    std::span<SymTensor> log_metric);

/// Collective. The metric of the second derivatives of a solution (hessian_metric()): with its clamps and its gradation
/// it has policy.complexity, if the sizes allow it. scalar: one value per local vertex, equal on all copies.
GradationReport metric_from_field(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy,
                                  std::span<const double> scalar, std::span<SymTensor> log_metric);

/// Collective. Sizes of more than 1e3 times the diagonal of the mesh, in any direction, become that: they are no limit.
/// Throws Error(kInput) on all ranks with the vertex for a size below 1e-100 diagonals.
void bound_sizes(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy, std::span<SymTensor> log_metric);

/// Collective. The whole policy: what metric_values() gave, in the column log_metric (kTensors, kSizes) or `fields`
/// (kField), becomes the logarithm of the metric to adapt to in log_metric. Given tensors and sizes are scaled to the
/// complexity (if there is one), then clamped, then graded; for a field see metric_from_field(). Tells what the
/// gradation did.
GradationReport make_metric(const Comm& comm, DistMesh& dist, const MetricPolicy& policy);

}  // namespace skein
