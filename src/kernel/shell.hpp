// The tetrahedra round an edge (its shell) and round a vertex (its ball).
#pragma once
#include <array>

#include "kernel/part.hpp"

namespace skein {

/// The two other vertices of each edge of kEdgeVerts, so that (edge, opposite) is an even permutation.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kEdgeOpposite{
    {{2, 3}, {3, 1}, {1, 2}, {0, 3}, {2, 0}, {0, 1}}};

/// The tetrahedra round edge (a, b) in order: tet[i] = (a, b, ring[i], ring[i+1]), positively oriented. A closed shell
/// has n ring vertices (ring[n] == ring[0]), an open one n+1, its first and last face being without a neighbour.
struct Shell {
  static constexpr int kMax = 48;
  VertId a, b;
  int n = 0;
  bool closed = false;
  bool on_interface = false;  ///< an end face is not on the hull: the edge is shared with another part
  std::array<TetId, kMax> tet;
  std::array<VertId, kMax + 1> ring;
  std::array<FaceTag, kMax + 1> tag;  ///< of the faces (a, b, ring[i])
  /// Ring vertices without repeating the first.
  [[nodiscard]] int ring_size() const noexcept { return closed ? n : n + 1; }
  [[nodiscard]] int tagged_faces() const noexcept;
};

/// Fills the shell of the edge (a, b) of t. False when it has more than `max` tetrahedra; then the first `max` of them
/// are there. @pre max <= Shell::kMax.
bool gather_shell(const TetMesh& mesh, TetId t, VertId a, VertId b, Shell& shell, int max = Shell::kMax) noexcept;

/// Bits of kEdgeVerts: the edges of t whose shells are certainly closed and have more than four tetrahedra; by a look
/// at the neighbours, without walking round.
unsigned large_rings(const TetMesh& mesh, TetId t) noexcept;

/// Tells the shell's tetrahedra that the operation at hand has been refused for its edge (Part::refused).
void mark_refused(Part& part, const Shell& shell) noexcept;

/// From the tetrahedra at v in `ball` (from `begin` on) over faces to all others at v. Calls meet(face) for the faces
/// that are come to (of tetrahedra that may be in the ball already); meet appends what is new to the ball, and stops
/// the walk by returning false. False when it was stopped or there are more than `max`.
template <class Meet>
bool walk_ball(const TetMesh& mesh, VertId v, std::vector<TetId>& ball, std::size_t begin, std::size_t max,
               Meet&& meet) {
  for (std::size_t i = begin; i < ball.size(); ++i) {
    const TetId t = ball[i];
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceId nb = mesh.tet2face[t][f];
      if (mesh.tet2vert[t][f] == v || nb == kNoFace) continue;
      if (!meet(nb)) return false;
    }
    if (ball.size() - begin > max) return false;
  }
  return true;
}

/// Appends all tetrahedra at v, whether they hang together or not, to `ball`, marking them with a new stamp
/// (Part::tet_stamp). False when there are more than `max`.
bool gather_ball(Part& part, VertId v, std::vector<TetId>& ball, std::size_t max = 1000);

}  // namespace skein
