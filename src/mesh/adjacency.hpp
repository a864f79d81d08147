// Adjacency of tetrahedra over their faces, and what follows from it.
#pragma once
#include <algorithm>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// Sets tet2face from tet2vert: faces with the same three vertices are neighbours; the others get kNoFace. Sets
/// vert2tet, too. face_tag is left as it is. Throws Error(kInvalidMesh) when a face has more than two tetrahedra (with
/// their numbers).
/// @pre no free tetrahedra.
void build_adjacency(TetMesh& mesh);
/// Sets kSurface, kRidge on vertices from face_tag and features (other flags stay).
void mark_boundary_vertices(TetMesh& mesh);
/// Removes free slots and renumbers vertices and tetrahedra along the Hilbert curve. Returns old vertex -> new vertex
/// (kNoVert for free ones), and old tetrahedron -> new tetrahedron where asked for.
IdVector<VertId, VertId> compact(TetMesh& mesh, IdVector<TetId, TetId>* tet_old2new = nullptr);

/// Takes the free slots out and keeps the order; cheap for a mesh that is nearly in order. Returns old vertex -> new
/// vertex (kNoVert for free ones), ascending.
IdVector<VertId, VertId> squeeze(TetMesh& mesh);
/// Follows a renumbering: v[i] goes to old2new[i], and is dropped where that is none. n: the new size.
template <class Id, class T>
void permute(IdVector<Id, T>& v, const IdVector<Id, Id>& old2new, std::size_t n) {
  IdVector<Id, T> out;
  out.reserve(std::max(v.raw().capacity(), n));  // what was to come still has its place
  out.resize(n);
  for (const Id i : IdRange<Id>(v.size())) {
    if (old2new[i] != to_id<Id>(-1)) out[old2new[i]] = v[i];
  }
  v = std::move(out);
}

/// The same for a renumbering that keeps the order, without a copy.
template <class Id, class T>
void squeeze(IdVector<Id, T>& v, const IdVector<Id, Id>& old2new, std::size_t n) {
  if (v.empty()) return;
  for (const Id i : IdRange<Id>(old2new.size())) {
    if (num(old2new[i]) >= 0) v[old2new[i]] = v[i];
  }
  v.resize(n);
}

}  // namespace skein
