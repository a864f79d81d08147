// Balance after the rounds by moving few tetrahedra across the interfaces.
#pragma once
#include <span>

#include "base/ids.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. A new rank for each local tetrahedron (as migrate() takes it), such that no rank's work exceeds the mean
/// by more than `imbalance`, or by the heaviest tetrahedron. Work flows between neighbouring ranks only; the flows are
/// those with the least sum of squares [HuBlake1999]. Tetrahedra move layer by layer from the interface, first those
/// that make it shorter. A rank without tetrahedra becomes a neighbour of one of the ranks with most work. Nothing
/// moves when the balance is good already. Ranks that no chain of interfaces connects are not balanced with each other.
/// When ranks differ by large factors, a new partition() moves no more and has shorter interfaces. Deterministic.
/// @pre work: one finite number >= 0 per tetrahedron; dist is compact.
IdVector<TetId, Rank> rebalance(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                double imbalance = 0.03);

}  // namespace skein
