// Moving the interfaces between rounds, and numbers for what a round has created.
#pragma once
#include <limits>

#include "comm/comm.hpp"
#include "partition/dist_mesh.hpp"

namespace skein {

inline constexpr GlobalId kEveryGlobal{std::numeric_limits<std::int64_t>::max()};  ///< above all global ids

/// Collective. A new rank for each tetrahedron such that old interfaces become interior: each shared vertex with a
/// global id below `before`, or within an edge of another that is kHeld, is given to one of its ranks, with all its
/// tetrahedra and `layers` more layers of tetrahedra. In round 1, with all interfaces at stake, Duels share them out
/// evenly; later one order of the ranks, another one in each round, leaves less. It also decides between two such
/// regions, so an old interface vertex stays shared only where they meet. Tetrahedra elsewhere stay. @pre layers >= 0.
IdVector<TetId, Rank> displace_interface(const Comm& comm, const DistMesh& dist, int layers, int round,
                                         GlobalId before = kEveryGlobal);

/// Collective. kHeld on the vertices that are shared now and have a global id below `before`, and on all copies of
/// those that have it; kActive on the vertices within `layers` edges (over all ranks) of these, cleared elsewhere.
/// Tells whether there are any on any rank.
bool mark_active_band(const Comm& comm, DistMesh& dist, int layers, GlobalId before = kEveryGlobal);

/// Collective. Vertices with kNoGlobal get global ids behind the largest there is: by rank, then local order. Sets the
/// global counts. Returns the lowest of the new ids, the same on all ranks. @pre no vertex with kNoGlobal is shared.
GlobalId number_new_vertices(const Comm& comm, DistMesh& dist);

/// Collective. Makes the global ids 0 .. global_verts-1: by owner (the lowest of its ranks), then local order there.
void renumber_compact(const Comm& comm, DistMesh& dist);

/// Collective. The numbers that renumber_compact gives, without changing the mesh.
std::vector<std::int64_t> compact_numbers(const Comm& comm, const DistMesh& dist);

}  // namespace skein
