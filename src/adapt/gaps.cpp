// Gaps: few are filled from the end, many are closed by moving up.
#include "adapt/gaps.hpp"

#include <algorithm>
#include <vector>

#include "mesh/adjacency.hpp"
#include "mesh/free_slots.hpp"

namespace skein {
namespace {

constexpr std::size_t kFew = 8;  ///< one free tetrahedron in so many, at most: more would scatter too much of the mesh

template <Identifier Id>
std::vector<Id> free_slots(const TetMesh& m, std::size_t n) {
  std::vector<Id> free;
  for (const Id i : IdRange<Id>(n)) {
    if (!m.is_live(i)) free.push_back(i);
  }
  return free;
}

IdVector<VertId, VertId> fill_gaps(TetMesh& m, const std::vector<TetId>& free_tets) {
  const auto free_verts = free_slots<VertId>(m, m.vert_slots());
  IdVector<VertId, VertId> old2new(m.vert_slots());
  for (const VertId v : IdRange<VertId>(old2new.size())) old2new[v] = v;
  for (const VertId v : free_verts) old2new[v] = kNoVert;
  fill_free_tets(m, free_tets);
  const MovedVerts now = fill_free_verts(m, free_verts);
  for (VertId& v : old2new) {
    if (v != kNoVert) v = now(v);
  }
  return old2new;
}

}  // namespace

bool are_few(std::size_t free_tets, std::size_t tets) noexcept { return kFew * free_tets <= tets; }

IdVector<VertId, VertId> close_gaps(TetMesh& mesh) {
  const auto free_tets = free_slots<TetId>(mesh, mesh.tet_slots());
  if (are_few(free_tets.size(), mesh.tet_slots())) return fill_gaps(mesh, free_tets);
  return squeeze(mesh);
}

}  // namespace skein
