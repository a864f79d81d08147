// Growing a mesh in steps until it can be cut for all ranks.
#pragma once
#include <span>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Into how many parts a mesh is worth cutting, at most one per worker (a rank, or a thread of one).
struct CutLimits {
  int wanted = 1;  ///< that the final mesh can feed: a smaller part is mostly interface
  int able = 1;    ///< that the mesh as it is can be cut into without the interfaces being most of it
};

/// Collective. From what each local tetrahedron will become (predicted_elements). What counts is not the number of
/// tetrahedra but how many of them share the growth, (sum e)^2 / sum e^2: when few of them become nearly all of the
/// final mesh, only these can be shared out. @pre workers >= 1.
CutLimits cut_limits(const Comm& comm, std::span<const double> elements, int workers);

/// Collective. Replaces the log-metric by a coarser one where more than `growth` elements per tetrahedron
/// would come of it: its sizes are multiplied by a common factor, but made no larger than half of the mesh's own, so
/// that nothing is removed that will be wanted again. @pre growth >= 8.
void bound_growth(const Comm& comm, DistMesh& dist, std::span<const double> elements, double growth);

}  // namespace skein
