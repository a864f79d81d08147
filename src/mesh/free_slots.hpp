// Slots that have become free in the arrays of a mesh, filled from the end: what is moved is as little as can be.
#pragma once
#include <span>
#include <vector>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// The places `free` (ascending, each once) of n are taken by what lies at the end: calls move(from, to) for each.
/// Gives what n becomes.
template <Identifier Id, class Move>
std::size_t fill_free_slots(const std::vector<Id>& free, std::size_t n, Move&& move) {
  std::size_t next = 0, left = free.size();
  while (next < left) {
    const Id last = to_id<Id>(--n);
    if (free[left - 1] == last) {
      --left;
    } else {
      move(last, free[next++]);
    }
  }
  return n;
}

/// Room for n items and a few more: growing the usual way doubles, and without any room left over the whole array would
/// be copied again for the next few items. What is only reserved takes no memory before it is touched.
template <class Vector>
void reserve_with_slack(Vector& v, std::size_t n) {
  constexpr std::size_t kSlack = 32;  // one more for so many
  if (n > v.capacity()) v.reserve(n + n / kSlack);
}

inline TetMesh& mesh_of(TetMesh& m) noexcept { return m; }

/// Makes neighbours of those among the faces that have the same vertices, also with one of the others; that two others
/// have is not looked for. @pre no three have the same.
void link_equal_faces(TetMesh& m, std::span<const FaceId> faces, std::span<const FaceId> others = {});

void resize_vert2tet(TetMesh& m, std::size_t n);
/// The arrays of the tetrahedra to n items.
void resize_tets(TetMesh& m, std::size_t n);
/// The same for the columns of the vertices that are there (of a mesh, or of what has one and more columns), and for
/// vert2tet; there is nothing in new entries.
template <class Mesh>
void resize_verts(Mesh& m, std::size_t n) {
  for_each_vert_column(m, [&](auto& c) {
    if (c.empty()) return;
    reserve_with_slack(c.raw(), n * width_of(c));
    resize_column(c, n);
  });
  resize_vert2tet(mesh_of(m), n);
}

/// The same by several threads, for more vertices than there are (grow_in_parallel).
void grow_verts(TetMesh& m, std::size_t n, int threads);

/// Takes out the tetrahedra `free` (ascending), to which nothing leads any more. Neighbours and vert2tet follow those
/// that move. @pre no other free slots.
void fill_free_tets(TetMesh& m, const std::vector<TetId>& free);

/// The numbers of items after some have moved to others' places.
template <Identifier Id>
class Moved {
 public:
  Moved() = default;
  Moved(std::size_t first, std::size_t n) : first_(first), old2new_(n, to_id<Id>(-1)) {}
  [[nodiscard]] Id operator()(Id i) const noexcept { return moves(i) ? old2new_[to_id<Id>(idx(i) - first_)] : i; }
  [[nodiscard]] bool moves(Id i) const noexcept { return idx(i) >= first_; }
  void set(Id from, Id to) noexcept { old2new_[to_id<Id>(idx(from) - first_)] = to; }

 private:
  std::size_t first_ = 0;     ///< all before it stay where they are
  IdVector<Id, Id> old2new_;  ///< of those from first_ on; -1 for free ones
};
using MovedVerts = Moved<VertId>;

/// Part of fill_free_verts: tetrahedra and feature edges take the vertices' new numbers.
void follow(TetMesh& m, const MovedVerts& now, int threads);

/// Takes out the vertices `free` (ascending), at which there are no tetrahedra. All columns (of a mesh, or of what has
/// one and more columns), tetrahedra and feature edges follow those that move.
template <class Mesh>
MovedVerts fill_free_verts(Mesh& all, const std::vector<VertId>& free, int threads = 1) {
  TetMesh& m = mesh_of(all);
  MovedVerts now(m.vert_slots() - free.size(), free.size());
  const std::size_t n = fill_free_slots(free, m.vert_slots(), [&](VertId from, VertId to) {
    move_entries(all, from, to);
    m.vert2tet[to] = m.vert2tet[from];
    now.set(from, to);
  });
  if (!free.empty()) follow(m, now, threads);
  resize_verts(all, n);
  return now;
}

}  // namespace skein
