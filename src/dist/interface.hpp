// Displacement of the interfaces between rounds, and global ids for the vertices that a round has created.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "dist/migrate.hpp"

namespace skein {

inline constexpr GlobalId kEveryGlobal{std::numeric_limits<std::int64_t>::max()};  ///< above all global ids

/// The region that the next round works on: the tetrahedra round the interfaces, or round the retry vertices (kRetry).
/// It marks the active vertices and displaces the interfaces. Its cost grows with the region, apart from one loop over
/// all tetrahedra.
class InterfaceRegion {
 public:
  /// Collective. `layers`: the largest number of layers that later calls will ask for. The mesh must outlive the
  /// region. Until then tetrahedra, interfaces and kRetry may change by mark_active only. All calls must have the same
  /// `before`.
  /// @pre layers >= 0.
  InterfaceRegion(const Comm& comm, DistMesh& dist, int layers);

  /// Collective. Sets kRetry on the vertices that are shared now and have a global id below `before`, and on all copies
  /// of vertices that have it already. Sets kActive on the vertices within `layers` edges of these, over all ranks, and
  /// clears it elsewhere. From vertices that had kRetry before, these layers reach all neighbours; from others only
  /// those with kBesideFrozen. Returns whether any rank has active vertices.
  bool mark_active(int layers, GlobalId before = kEveryGlobal);

  /// Collective. New ranks for tetrahedra, such that old interfaces become interior. Each shared vertex with a global
  /// id below `before`, and each shared vertex that is or has as neighbour a retry vertex, is given to one of its
  /// ranks, with all its tetrahedra and `layers` more layers. In round 1 this concerns all interfaces, and Winners
  /// distributes them evenly. Later the rank with the fewest tetrahedra gets them, so that the displacement also evens
  /// out the ranks. Where two such regions meet, the same order decides; only there does an old interface vertex stay
  /// shared. Tetrahedra elsewhere stay.
  [[nodiscard]] Moves displace(int layers, int round, GlobalId before = kEveryGlobal);

 private:
  using Labels = std::vector<std::int64_t>;  ///< per vertex; 0: none
  /// The array of labels, without any.
  Labels& no_labels();
  void find_tets(GlobalId before);
  template <class Wanted>
  void spread(const std::vector<TetId>& tets, Labels& label, Wanted&& wanted) const;
  void spread(const std::vector<TetId>& tets, Labels& label) const;
  [[nodiscard]] std::vector<char> to_be_freed(GlobalId before);

  const Comm& comm_;
  DistMesh& dist_;
  Halo halo_;
  int layers_;
  bool found_ = false;                      ///< tets_ has been computed (when it was first needed)
  std::vector<TetId> tets_;                 ///< ascending
  std::vector<TetId> near_retry_;           ///< those of them within kReach of a retry vertex
  std::optional<std::vector<TetId>> open_;  ///< tetrahedra with a face without neighbour, if known
  Labels label_;                            ///< one array for all steps
};

/// Collective. Gives global ids to the vertices with kNoGlobal, above the largest that exists: by rank, then local
/// order. Sets the global counts. Returns the lowest new id, the same on all ranks. @pre no vertex with kNoGlobal is
/// shared.
GlobalId number_new_vertices(const Comm& comm, DistMesh& dist);

/// Collective. Makes the global ids 0 .. global_verts-1: by owner (the lowest of its ranks), then local order there.
void renumber_compact(const Comm& comm, DistMesh& dist);

/// Collective. The numbers that renumber_compact gives, without changing the mesh.
std::vector<std::int64_t> compact_numbers(const Comm& comm, const DistMesh& dist);

}  // namespace skein
