// Migration: tetrahedra change their rank with all that hangs on them.
#pragma once
#include "comm/comm.hpp"
#include "partition/dist_mesh.hpp"

namespace skein {

/// Collective. Moves each tetrahedron t to rank dest[t] with its tags and reference, its vertices (coordinates,
/// reference, flags, data, global id) and the feature edges that are its edges. Copies of a vertex that meet become
/// one; all copies of a shared vertex get the flags that any of them has. Adjacency, sharing lists, kFrozen (set on
/// shared vertices, nowhere else) and the global counts are made anew. Order after it: what stayed in its old order,
/// then what came by source rank in its order there; no free slots. Throws Error(kInternal) on all ranks when a
/// destination is not a rank, or a vertex has no global id.
/// @pre dist is compact, all vertices have global ids, sharing is right (reconcile() passes); dest has one rank per
/// tetrahedron.
void migrate(const Comm& comm, DistMesh& dist, const IdVector<TetId, Rank>& dest);

}  // namespace skein
