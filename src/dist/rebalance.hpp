// Balance between rounds by moving few tetrahedra across the interfaces.
#pragma once
#include <span>

#include "base/ids.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. A new rank for each local tetrahedron (as migrate() takes it), such that no rank has more than 1 +
/// `imbalance` of the mean work, or the heaviest tetrahedron more. Work flows between neighbouring ranks only, as much
/// as the least sum of squares of all flows takes; tetrahedra go layer by layer from the interface, those first that
/// make it shorter. A rank without tetrahedra gets one of the ranks with most work as neighbour. Nothing moves when the
/// balance is good already. Ranks between which no interface leads stay as unequal as they are; when ranks differ by
/// large factors, a new partition() moves no more and has shorter interfaces. Deterministic. (Flow: Y. Hu, R. Blake,
/// Parallel Computing 25, 1999.)
/// @pre work: one finite number >= 0 per tetrahedron; dist is compact.
IdVector<TetId, Rank> rebalance(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                double imbalance = 0.03);

}  // namespace skein
