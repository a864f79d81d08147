// Migration: tetrahedra move to other ranks, with their vertices and attributes.
#pragma once
#include <optional>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Tetrahedra that move to other ranks; all others stay.
struct Moves {
  std::vector<TetId> tets;  ///< ascending
  std::vector<Rank> to;     ///< one for each of them
  /// All tetrahedra with a face without a neighbour, if the caller knows them: saves a loop over all tetrahedra.
  std::optional<std::vector<TetId>> open = {};
};

/// Collective. Moves tetrahedra to other ranks with their tags and references, their vertices (all columns,
/// global id) and the feature edges that are their edges. Copies of a vertex that meet become one with
/// the flags of both; merge_vertex_flags() then says which flags all copies of a shared vertex get. Adjacency, sharing
/// lists, kFrozen (set on shared vertices, nowhere else) and the global counts are right after it. What comes, by
/// source rank in its order there, takes the places of what has gone and then new ones; places that are left over are
/// filled from the end. The cost grows with what moves and with the interface, but for two looks at the tetrahedra of
/// ranks where anything does. Throws Error(kInternal) on all ranks when a destination is not a rank, a vertex has no
/// global id, or a rank with vertices lacks a column that another has.
/// @pre dist is compact, all vertices have global ids, sharing is right (reconcile() passes).
void migrate(const Comm& comm, DistMesh& dist, const Moves& moves);
/// The same with a rank for each tetrahedron.
void migrate(const Comm& comm, DistMesh& dist, const IdVector<TetId, Rank>& dest);
/// The same with a part for each tetrahedron; part p goes to rank p.
void migrate(const Comm& comm, DistMesh& dist, const IdVector<TetId, PartId>& dest);

}  // namespace skein
