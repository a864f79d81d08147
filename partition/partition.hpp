// Partition of a distributed mesh: who shall have which tetrahedron, by predicted work, and how good that is.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"
#include "mesh/ids.hpp"
#include "partition/dist_mesh.hpp"

namespace skein {

enum class PartitionMethod { kHilbert, kMultilevel };

/// Collective. The part, in [0, parts), of each local tetrahedron, so that all parts have nearly equal work.
/// `threads`: in each rank, for what can be threaded. @pre tet_work: one number >= 0 per local tetrahedron.
IdVector<TetId, Rank> partition(const Comm& comm, const DistMesh& dist, std::span<const double> tet_work, int parts,
                                PartitionMethod method = PartitionMethod::kHilbert, int threads = 1);

/// How many tetrahedra will be in the place of each one after an adaptation: 10 * integral of sqrt(det M), the
/// log-metric being the first 6 data numbers. 1 when data.width < 6.
std::vector<double> predicted_elements(const DistMesh& dist);
/// Expected cost of each tetrahedron in an adaptation, in units of what it takes to make a new one for an isotropic
/// metric: those that are made for another cost up to 1.4 times as much, those that go somewhat less, those that stay
/// a third. 1 when data.width < 6.
std::vector<double> predicted_work(const DistMesh& dist);

struct PartitionStats {
  std::int64_t cut_faces = 0;   ///< faces between tetrahedra of different parts
  double imbalance = 0;         ///< largest work of a part / mean work - 1
  std::int64_t components = 0;  ///< face-connected pieces of all parts together; at best the number of parts
};
/// Collective. Same result on every rank. @pre part in [0, parts).
PartitionStats partition_stats(const Comm& comm, const DistMesh& dist, const IdVector<TetId, Rank>& part,
                               std::span<const double> tet_work, int parts);

}  // namespace skein
