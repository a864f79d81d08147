// Vertices of a file that are nearer to each other than a tolerance become one.
#pragma once
#include <cstdint>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// Over all ranks.
struct MergeReport {
  std::int64_t verts = 0;      ///< vertices that are gone
  std::int64_t tets = 0;       ///< tetrahedra, triangles and edges that are gone: with a vertex twice,
  std::int64_t triangles = 0;  ///< or (triangles, edges) the same as another
  std::int64_t edges = 0;
};

/// Collective. Joins vertices that are at most `tolerance` times the diagonal of the bounding box apart, also in
/// chains: the one with the lowest number stays where it is, with its reference and its row of `values` (may be null;
/// at the same vertices in the same slices). Tetrahedra, triangles and edges that have collapsed are dropped, and
/// triangles and edges that are given again then, whatever their reference: the first stays. Numbers of vertices and
/// entities close up, in their old order; slices keep their ranks. No rank holds the whole mesh. Throws
/// Error(kInvalidMesh) on all ranks for coordinates that are not finite, and for vertex numbers out of range. @pre
/// tolerance >= 0
MergeReport merge_vertices(const Comm& comm, double tolerance, MeshSlice& mesh, FieldSlice* values = nullptr);

}  // namespace skein
