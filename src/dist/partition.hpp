// Partition of a distributed mesh: who shall have which tetrahedron, by predicted work, and how good that is.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/ids.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

enum class PartitionMethod { kHilbert, kMultilevel };

/// Of multilevel_partition() of a mesh.
struct MeshCutOptions {
  double imbalance = 0.03;  ///< a part may have this much more than the mean work, or the heaviest tetrahedron more
  /// What it costs to cut a face: one number >= 1 per FaceId (4 per tetrahedron), empty: 1 everywhere. Of the two sides
  /// of a face the larger number counts. At most 1000, so that sums fit.
  std::span<const std::int32_t> face_weight = {};
  int threads = 1;  ///< in each rank
};
/// Collective. The part, in [0, parts), of each local tetrahedron: multilevel_partition() of the dual graph.
/// @pre work: one finite number >= 0 per local tetrahedron; parts >= 1; dist is compact.
IdVector<TetId, PartId> multilevel_partition(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                             int parts, const MeshCutOptions& options = {});

/// The rank that part p belongs to is rank p.
IdVector<TetId, Rank> to_ranks(const IdVector<TetId, PartId>& part);

/// Collective. The part, in [0, parts), of each local tetrahedron, so that all parts have nearly equal work.
/// `threads`: in each rank, for what can be threaded. @pre tet_work: one number >= 0 per local tetrahedron.
IdVector<TetId, PartId> partition(const Comm& comm, const DistMesh& dist, std::span<const double> tet_work, int parts,
                                  PartitionMethod method = PartitionMethod::kHilbert, int threads = 1);

/// How many tetrahedra will be in the place of each one after an adaptation: 10 * integral of sqrt(det M)
/// (vertex_face_rule), the log-metric being the first 6 data numbers. 1 when data.width < 6.
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
PartitionStats partition_stats(const Comm& comm, const DistMesh& dist, const IdVector<TetId, PartId>& part,
                               std::span<const double> tet_work, int parts);

}  // namespace skein
