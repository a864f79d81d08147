// Removing free slots from a mesh and from the metric at its vertices.
#pragma once
#include "mesh/tet_mesh.hpp"
#include "metric/metric_field.hpp"

namespace skein {

/// Tells whether free slots are so few that the last tetrahedra can fill them, without moving all others up.
bool are_few(std::size_t free_tets, std::size_t tets) noexcept;

/// Removes the free slots from mesh and metric. Where they are few, as after adaptation, the last items move into them.
/// Otherwise all items move up, which keeps their order. Returns old vertex -> new vertex, kNoVert for free ones.
IdVector<VertId, VertId> close_gaps(TetMesh& mesh, MetricField& metric);

}  // namespace skein
