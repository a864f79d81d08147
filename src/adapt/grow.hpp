// Growing a mesh in steps until it can be cut for all ranks.
#pragma once
#include <span>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "kernel/method.hpp"

namespace skein {

/// The largest useful number of parts, at most one per worker (a rank, or a thread of a rank).
struct CutLimits {
  int wanted = 1;  ///< for the final mesh: with more parts, these would be mostly interface
  int able = 1;    ///< for the mesh as it is now
};

/// Collective. `elements`: how many tetrahedra will be in the place of each local one (predicted_elements). For the
/// mesh as it is, tetrahedra are counted by how they share the growth, (sum e)^2 / sum e^2: when a few of them become
/// nearly all of the final mesh, only these few can be distributed. @pre workers >= 1.
CutLimits cut_limits(const Comm& comm, std::span<const double> elements, int workers,
                     const Method::Growth& method = {});

/// Collective. Replaces the log-metric by a coarser one where more than `growth` elements per tetrahedron
/// would come of it: its sizes are multiplied by a common factor, but made no larger than half of the mesh's own, so
/// that nothing is removed that will be wanted again. @pre growth >= 8.
void bound_growth(const Comm& comm, DistMesh& dist, std::span<const double> elements, double growth);

}  // namespace skein
