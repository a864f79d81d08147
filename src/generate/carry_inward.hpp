// Boundary spacing and how it is carried into the volume [HassanProbert1999, 35.2.3.1].
#pragma once
#include <array>
#include <span>
#include <vector>

#include "mesh/mesh_slice.hpp"

namespace skein {

/// Mean length of the triangle edges at each vertex (each edge once). @pre the surface is whole, every vertex is used.
std::vector<double> boundary_spacing(const MeshSlice& surface);

/// Lowers the spacing of every vertex from number `fixed` on until, along each edge, it is at most the neighbour's
/// spacing plus `growth` times the length of the edge. The first `fixed` vertices keep their spacing.
/// @pre growth > 0; spacing has one value > 0 (or infinity) per vertex, a finite one somewhere.
void carry_inward(std::span<const Vec3> coords, std::span<const std::array<GlobalId, 4>> tets, std::size_t fixed,
                  double growth, std::span<double> spacing);

}  // namespace skein
