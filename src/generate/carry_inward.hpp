// Boundary spacing and how it is carried into the volume [35.2.3.1].
#pragma once
#include <array>
#include <span>
#include <vector>

#include "mesh/mesh_slice.hpp"

namespace skein {

/// Mean length of the triangle edges at each vertex (each edge once). @pre the surface is whole, every vertex is used.
std::vector<double> boundary_spacing(const MeshSlice& surface);

/// For every vertex from `fixed` on: the least, over the edges of the tetrahedra, of its own spacing and of a
/// neighbour's spacing plus `growth` times the edge's length. The first `fixed` keep theirs.
/// @pre growth > 0; spacing has one value > 0 (or infinity) per vertex, a finite one somewhere.
void carry_inward(std::span<const Vec3> coords, std::span<const std::array<GlobalId, 4>> tets, std::size_t fixed,
                  double growth, std::span<double> spacing);

}  // namespace skein
