// The metric that a mesh has by itself: the sizes and directions of its own edges.
#pragma once
#include <vector>

#include "base/tensor.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. The logarithm of M = (3 C)^-1 at each local vertex, C the mean of e e' over the edges e at the vertex,
/// each as often as there are tetrahedra at it: edges that point evenly in all directions have the length 1 in it in
/// the mean, stretched ones give a stretched metric. Scaled so that an adaptation to it gives as many tetrahedra as
/// this one. Equal on all copies of a vertex.
std::vector<SymTensor> own_log_metric(const Comm& comm, const DistMesh& dist);

}  // namespace skein
