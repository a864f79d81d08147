// Metrics, sizes and solutions as they are given, before the mesh is distributed.
#pragma once
#include "base/tensor.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// What the numbers at the vertices are.
enum class MetricSource {
  kTensors,  ///< metrics: six numbers, symmetric positive definite, 1/length^2
  kSizes,    ///< wanted edge lengths
  kField,    ///< solutions, one or several: the metric is that of their second derivatives
  kMesh,     ///< no numbers: the metric of the mesh's own edges
};

/// What distribute() takes of values as they are given: the logarithm of the metric for kTensors and kSizes, the scalar
/// itself for kField. Not collective. Throws Error(kInput) with the path of `given` and the number of the vertex for a
/// metric with a negative eigenvalue (with all three), a size that is not greater than zero, and for what is not
/// finite. An eigenvalue of zero is no limit of the size in its direction. @pre one field of the source's kind
FieldSlice metric_values(FieldSlice given, MetricSource source);

/// The logarithm of the metric that is as strict as both whose logarithms are given, in every direction.
SymTensor strictest(const SymTensor& log_a, const SymTensor& log_b);
/// The eigenvalues of the logarithm raised to this one where they are less: no size above exp(-log_eigenvalue/2).
SymTensor at_least(const SymTensor& log_m, double log_eigenvalue);
/// Vertex by vertex the strictest of both. Not collective. @pre the same vertices, as metric_values() gave them, of
/// kTensors or kSizes
FieldSlice strictest(FieldSlice a, const FieldSlice& b);

}  // namespace skein
