// Taking free slots out of a mesh.
#pragma once
#include "mesh/tet_mesh.hpp"

namespace skein {

/// So few free tetrahedra that the others need not move up to close the gaps.
bool are_few(std::size_t free_tets, std::size_t tets) noexcept;

/// Takes the free slots out of the mesh. Where they are few, as after adaptation, what lies at the end moves
/// into them, else all moves up, which keeps the order. Returns old vertex -> new vertex, kNoVert for free ones.
IdVector<VertId, VertId> close_gaps(TetMesh& mesh);

}  // namespace skein
