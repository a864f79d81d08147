// Moving the interfaces between rounds, and numbers for what a round has created.
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

/// The tetrahedra round what is to be worked on again, interfaces as a whole or what is kRetry, and what rounds do
/// there. What is done costs as much as there is, but for one look at the whole mesh.
class InterfaceRegion {
 public:
  /// Collective. `layers`: the most that will be asked for. The mesh must outlive the region; tetrahedra, interfaces
  /// and kRetry may change only by mark_active. All calls have the same `before`. @pre layers >= 0.
  InterfaceRegion(const Comm& comm, DistMesh& dist, int layers);

  /// Collective. kRetry on the vertices that are shared now and have a global id below `before`, and on all copies of
  /// those that have it; kActive on the vertices within `layers` edges (over all ranks) of these, cleared elsewhere.
  /// These steps go to vertices that are kBesideFrozen, from what was kRetry to all.
  /// Tells whether there are any on any rank.
  bool mark_active(int layers, GlobalId before = kEveryGlobal);

  /// Collective. New ranks for tetrahedra such that old interfaces become interior: each shared vertex with a global id
  /// below `before`, or within an edge of another that is kRetry, is given to one of its ranks, with all its tetrahedra
  /// and `layers` more layers of tetrahedra. In round 1, with all interfaces at stake, Winners share them out evenly;
  /// later they go to the rank with the fewest tetrahedra, so that what moves anyway flows from heavy ranks to light
  /// ones. This order also decides between two such regions, so an old interface vertex stays shared only where they
  /// meet. Tetrahedra elsewhere stay.
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
  bool found_ = false;                      ///< tets_ is there: not before it is needed
  std::vector<TetId> tets_;                 ///< ascending
  std::vector<TetId> near_retry_;           ///< those of them within kReach of what is held
  std::optional<std::vector<TetId>> open_;  ///< of the mesh, if known
  Labels label_;                            ///< one array for all steps
};

/// Collective. Vertices with kNoGlobal get global ids behind the largest there is: by rank, then local order. Sets the
/// global counts. Returns the lowest of the new ids, the same on all ranks. @pre no vertex with kNoGlobal is shared.
GlobalId number_new_vertices(const Comm& comm, DistMesh& dist);

/// Collective. Makes the global ids 0 .. global_verts-1: by owner (the lowest of its ranks), then local order there.
void renumber_compact(const Comm& comm, DistMesh& dist);

/// Collective. The numbers that renumber_compact gives, without changing the mesh.
std::vector<std::int64_t> compact_numbers(const Comm& comm, const DistMesh& dist);

}  // namespace skein
