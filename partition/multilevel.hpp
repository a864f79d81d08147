// Multilevel partition of the dual graph: short interfaces at a bounded imbalance.
#pragma once
#include <cstdint>
#include <span>

#include "comm/comm.hpp"
#include "mesh/ids.hpp"
#include "partition/dist_mesh.hpp"

namespace skein {

struct MultilevelOptions {
  double imbalance = 0.03;  ///< a part may have this much more than the mean work, or the heaviest tetrahedron more
  /// What it costs to cut a face: one number >= 1 per FaceId (4 per tetrahedron), empty: 1 everywhere. Of the two sides
  /// of a face the larger number counts. At most 1000, so that sums fit.
  std::span<const std::int32_t> face_weight = {};
  int threads = 1;  ///< in each rank: graphs are made and made coarser, and first cuts tried, by as many
};

/// Collective. The part, in [0, parts), of each local tetrahedron. Every rank makes its graph coarser by pairs inside
/// the rank; the coarse graphs together, of bounded size, are on every rank, which cuts them with a seed of its own;
/// the best cut of all ranks is carried back to the tetrahedra and improved on each level, in turns where ranks meet.
/// Pieces that are cut off from the rest of their part go to a neighbour, which passes on what it has too much by that,
/// until all parts are connected or ten attempts have found nothing better. Parts are empty when there are more of them
/// than tetrahedra. Deterministic for the same distribution and threads. (Heavy-edge coarsening and k-way refinement:
/// G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20, 1998; local search with rollback: C. Fiduccia, R. Mattheyses, 1982.)
/// @pre work: one finite number >= 0 per local tetrahedron; parts >= 1; dist is compact.
IdVector<TetId, Rank> multilevel_partition(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                           int parts, const MultilevelOptions& options = {});

}  // namespace skein
