// Which ranks share which vertices: sharing lists made from the mesh, and flags that must agree on all copies.
#pragma once
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// The vertices of these faces, each once.
std::vector<VertId> verts_of(const TetMesh& mesh, const std::vector<FaceId>& faces);

/// Collective. Those of the vertices `among` that other ranks have, too, by a rendezvous. @pre all shared vertices are
/// in `among`. The vertices of all faces without a local neighbour suffice. Those of hull faces are needed, too: two
/// ranks may have tetrahedra at a vertex and no common face there. Vertices with kNoGlobal are new and not shared.
Sharing find_sharing(const Comm& comm, const std::vector<VertId>& among, const IdVector<VertId, GlobalId>& vert2gid);

/// Collective. find_sharing into dist.sharing; kFrozen on the shared vertices and nowhere else. Without `among`, from
/// the faces of the whole mesh.
void rebuild_sharing(const Comm& comm, DistMesh& dist);
void rebuild_sharing(const Comm& comm, DistMesh& dist, const std::vector<VertId>& among);

/// Collective. Every copy of a shared vertex gets the flags that any copy has: all of VertClass, and of VertState
/// kFrozen and kActive. The other states tell what a rank has met in its own tetrahedra, and stay as they are.
void merge_vertex_flags(const Comm& comm, DistMesh& dist);

/// Collective. Sets global_tets and global_verts (shared vertices once).
void count_global(const Comm& comm, DistMesh& dist);

/// Nonzero for each vertex that this rank owns: not shared, or shared with higher ranks only.
IdVector<VertId, char> owned_verts(const Comm& comm, const DistMesh& dist);

/// Renumbers vertices and tetrahedra along the Hilbert curve, with all their attributes, and removes free slots.
/// Not collective.
void compact(DistMesh& dist);

}  // namespace skein
