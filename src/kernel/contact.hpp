// Where bodies touch: vertices whose tetrahedra do not hang together over faces.
#pragma once
#include <span>
#include <vector>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// Tetrahedra at every kContact vertex, at least one of each set that hangs together over faces, so that a walk over
/// faces finds all the others. A mesh without such vertices costs nothing.
class ContactFans {
 public:
  /// Looks for them in the whole mesh.
  void find(const TetMesh& mesh);
  /// No vertex is kContact.
  [[nodiscard]] bool empty() const noexcept { return list_of_.empty(); }
  /// Some tetrahedra at v. Some of them may be gone, or no longer have v (see is_at).
  [[nodiscard]] std::span<const TetId> at(VertId v) const noexcept;
  /// t has v now, in the place of others that had it.
  void note(const TetMesh& mesh, VertId v, TetId t);
  static bool is_at(const TetMesh& mesh, TetId t, VertId v) noexcept;

 private:
  struct List {
    std::vector<TetId> tets;
    std::size_t tidy_above = 32;  ///< so many items: those that are gone are taken out
  };
  static void tidy(const TetMesh& mesh, VertId v, List& list);
  IdVector<VertId, std::int32_t> list_of_;  ///< -1: none; empty without contacts
  std::vector<List> lists_;
};

}  // namespace skein
