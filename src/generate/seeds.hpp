// Seeds: a few points inside the domain. They carry the wanted spacing where surfaces of different spacing are far
// apart.
#pragma once
#include <vector>

#include "mesh/mesh_slice.hpp"
#include "metric/spacing.hpp"

namespace skein {

/// The centres of the cells of a balanced octree, moved by a fixed pseudo-random amount. A cell is up to `ratio` times
/// as large as the spacing wanted in it by the surface and the sources. When there are too many cells for one rank,
/// ratio is doubled. No seed lies near the surface; seeds outside the domain are still among them.
///
/// Without seeds an edge of the first tetrahedra could reach from the finest to the coarsest surface. The spacing in
/// between would then be interpolated from two values, and a source away from the surfaces would have no effect. More
/// seeds also give better interfaces between ranks: with a ratio of 6 four ranks made 7 % more tetrahedra in a ball
/// than one rank, with a ratio of 3 less than 3 %.
/// @pre spacing has one value per vertex of the surface; the surface is whole.
std::vector<Vec3> make_seeds(const MeshSlice& surface, const std::vector<double>& spacing, const SpacingField& sources,
                             double ratio = 3);

}  // namespace skein
