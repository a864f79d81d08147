// Partition of a distributed mesh: which part each tetrahedron belongs to, by predicted work, and how good that is.
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
  double imbalance = 0.03;  ///< a part's work may exceed the mean by this share, or by the heaviest tetrahedron
  /// Weight of each face when it is cut: one number from 1 to 1000 per FaceId (4 per tetrahedron); empty: 1 everywhere.
  /// If the two sides of a face differ, the larger number counts.
  std::span<const std::int32_t> face_weight = {};
  int threads = 1;  ///< in each rank
};
/// Collective. The part, in [0, parts), of each local tetrahedron: multilevel_partition() of the dual graph.
/// @pre work: one finite number >= 0 per local tetrahedron; parts >= 1; dist is compact.
IdVector<TetId, PartId> multilevel_partition(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                             int parts, const MeshCutOptions& options = {});

/// Part p goes to rank p.
IdVector<TetId, Rank> to_ranks(const IdVector<TetId, PartId>& part);

/// Collective. The part, in [0, parts), of each local tetrahedron, so that all parts have nearly equal work.
/// `threads`: in each rank, for what can be threaded. @pre tet_work: one number >= 0 per local tetrahedron.
IdVector<TetId, PartId> partition(const Comm& comm, const DistMesh& dist, std::span<const double> tet_work, int parts,
                                  PartitionMethod method = PartitionMethod::kHilbert, int threads = 1);

/// How many tetrahedra will be in the place of each one after an adaptation: 10 * integral of sqrt(det M)
/// (vertex_face_rule), by the column log_metric. 1 without it.
std::vector<double> predicted_elements(const TetMesh& mesh);
/// Expected cost of each tetrahedron in an adaptation. The unit is the cost of making one tetrahedron for an isotropic
/// metric. One that is made for an anisotropic metric costs up to 1.6 times as much, one that goes three quarters, one
/// that stays about a quarter. 1 without a log_metric.
std::vector<double> predicted_work(const TetMesh& mesh);

struct PartitionStats {
  std::int64_t cut_faces = 0;   ///< faces between tetrahedra of different parts
  double imbalance = 0;         ///< largest work of a part / mean work - 1
  std::int64_t components = 0;  ///< face-connected pieces of all parts together; at best the number of parts
};
/// Collective. Same result on every rank. @pre part in [0, parts).
PartitionStats partition_stats(const Comm& comm, const DistMesh& dist, const IdVector<TetId, PartId>& part,
                               std::span<const double> tet_work, int parts);

}  // namespace skein
