// Is a TetMesh consistent? For assertions and tests; tells the first fault in words.
#pragma once
#include <string>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// Empty when the mesh is valid: every live tetrahedron has positive (exact) volume and live vertices, adjacency is
/// symmetric and orientation agrees, tags of both sides agree, hull tags have no neighbour, vert2tet is at the vertex,
/// feature edges have live ends marked kRidge, vertices of tagged faces are marked kSurface. Otherwise the first fault.
std::string check(const TetMesh& mesh);

/// Empty when every array has one entry per slot and every column that is there one per vertex; else the first fault.
std::string check_sizes(const TetMesh& mesh);

/// Sum of the volumes of live tetrahedra.
double volume(const TetMesh& mesh) noexcept;
/// Number of live tetrahedra.
std::size_t count_tets(const TetMesh& mesh) noexcept;
/// Area of the hull and internal faces with this patch (internal ones count once per side).
double patch_area(const TetMesh& mesh, int patch) noexcept;

}  // namespace skein
