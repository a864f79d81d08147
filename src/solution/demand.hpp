// What a metric asks for, before any work is done for it.
#pragma once
#include <string>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Memory that a run takes for each tetrahedron of its result, over all ranks: measured 125 to 155 bytes.
inline constexpr double kBytesPerTet = 160;

/// Collective. The tetrahedra of the mesh that an adaptation makes of the metric whose logarithm, linear in each
/// tetrahedron, is in log_metric: exact integrals where it varies much, unlike the complexity, which knows the vertices
/// only.
double predicted_tets(const Comm& comm, const DistMesh& dist);

/// Collective. Throws Error(kInput) on all ranks, with both numbers, when more tetrahedra are predicted than `most`,
/// or, if that is 0, than there is memory for. `name` is what asks for them. Gives predicted_tets().
double require_affordable(const Comm& comm, const DistMesh& dist, const std::string& name, double most);

}  // namespace skein
