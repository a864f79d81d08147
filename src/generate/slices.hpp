// From even slices to one rank and back: the surface goes to rank 0 for TetGen, the volume mesh comes back.
#pragma once
#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// Collective. All vertices and surface entities on rank 0 (nothing elsewhere). Tetrahedra are left out: a
/// surface is small against its volume, a volume mesh is not.
MeshSlice gather_surface(const Comm& comm, const MeshSlice& slice);

/// Collective. Rank 0's whole mesh as even slices on all ranks. `whole` is ignored on the other ranks.
MeshSlice scatter_mesh(const Comm& comm, const MeshSlice& whole);

/// Collective. Rank 0's values, `width` per vertex of total_verts, as even slices on all ranks.
std::vector<double> scatter_values(const Comm& comm, std::int64_t total_verts, int width,
                                   const std::vector<double>& whole);

}  // namespace skein
