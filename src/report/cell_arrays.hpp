// Numbers of each tetrahedron and vertex, for pictures: where is the mesh bad?
#pragma once
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "report/statistics.hpp"

namespace skein {

/// Per tetrahedron: quality (in the metric or in space), the mean length of its edges (likewise), aspect ratio (longest
/// edge over shortest height, 1 for the regular tetrahedron), smallest dihedral angle, part.
inline constexpr int kCellArrays = 5;

/// Collective. Of the tetrahedra of this rank, in the order in which to_slices() gives them.
FieldSlice cell_arrays(const Comm& comm, const DistMesh& dist, Measure measure);
/// Collective. Of slices as a file has them, in space.
FieldSlice cell_arrays(const Comm& comm, const MeshSlice& mesh);
/// Collective. `size` (edge of a cube of the volume that a unit cube has in the metric) and `metric` at the vertices,
/// behind the numbers of `fields`, which may be empty.
FieldSlice with_metric_arrays(const Comm& comm, const DistMesh& dist, FieldSlice fields);

}  // namespace skein
