// Seeds: a thin cloud of points inside the domain that carries spacing between surfaces of very different spacing.
#pragma once
#include <vector>

#include "mesh/mesh_slice.hpp"
#include "metric/spacing.hpp"

namespace skein {

/// Centres (jittered, always the same) of a balanced octree whose cells are up to `ratio` times as large as the spacing
/// wanted in them, by the surface spacing and by the sources. When there are too many for one rank, ratio is doubled.
/// None lies near the surface; those outside the domain are still among them.
///
/// Without seeds the first tetrahedra would reach from the finest to the coarsest surface in one edge, the spacing in
/// between would follow from two values, and a source away from the surfaces would not be seen at all. Many seeds also
/// make fine interfaces between ranks: with a ratio of 6 four ranks made 7 % more tetrahedra of a ball than one, with 3
/// it was less than 3 %.
/// @pre spacing has one value per vertex of the surface; the surface is whole.
std::vector<Vec3> make_seeds(const MeshSlice& surface, const std::vector<double>& spacing, const SpacingField& sources,
                             double ratio = 3);

}  // namespace skein
