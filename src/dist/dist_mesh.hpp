// DistMesh: the mesh in parts, one per rank.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "comm/halo.hpp"
#include "mesh/tet_mesh.hpp"

namespace skein {

/// One rank's part of a distributed mesh. Compact: no free slots. Each tetrahedron is on one rank; a vertex is on
/// every rank that has a tetrahedron at it. A local face without a neighbour and without kHullFace is on the
/// interface. patch_ref is the same on every rank. A feature edge is on every rank that has a tetrahedron with this
/// edge; other ranks with both of its vertices may have it, too.
struct DistMesh {
  TetMesh mesh;
  IdVector<VertId, GlobalId> vert2gid;
  Sharing sharing;                ///< the vertices that other ranks have, too
  std::int64_t global_verts = 0;  ///< over all ranks, shared ones once
  std::int64_t global_tets = 0;
};

inline TetMesh& mesh_of(DistMesh& dist) noexcept { return dist.mesh; }

/// Calls f(column) for the columns of the mesh and vert2gid.
template <class F>
void for_each_vert_column(DistMesh& dist, F&& f) {
  for_each_vert_column(dist.mesh, f);
  f(dist.vert2gid);
}
template <class F>
void for_each_vert_column(const DistMesh& dist, F&& f) {
  for_each_vert_column(dist.mesh, f);
  f(dist.vert2gid);
}

}  // namespace skein
