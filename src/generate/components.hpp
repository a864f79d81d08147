// The components (closed pieces) of an oriented surface: which lies inside which, and points inside the voids.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "base/ids.hpp"
#include "base/vec3.hpp"

namespace skein {

/// Sum of the solid angles of the triangles seen from x, over 4 pi: 1 inside a closed surface oriented outwards, 0
/// outside, -1 inside one oriented inwards.
double winding_number(std::span<const Vec3> coords, std::span<const std::array<GlobalId, 3>> triangles,
                      Vec3 x) noexcept;

struct Shells {
  std::vector<std::vector<std::array<GlobalId, 3>>> triangles;  ///< per component; each one oriented outwards
  std::vector<std::vector<std::size_t>> number;                 ///< per component, triangle of the whole surface
  std::vector<int> depth;                                       ///< per component, in how many others it lies
};

/// Fills `depth` from `triangles`.
void find_depths(std::span<const Vec3> coords, Shells& shells);

/// A point inside each component of odd depth, and outside of the components in it. Throws Error(kInvalidMesh) when
/// none is found.
std::vector<Vec3> find_voids(std::span<const Vec3> coords, const Shells& shells);

}  // namespace skein
