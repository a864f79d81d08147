// The boundary-conforming tetrahedralisation of a closed surface, by TetGen [TetGen]. Serial.
#pragma once
#include <array>
#include <vector>

#include "generate/surface_check.hpp"

namespace skein {

/// True when Skein was built with TetGen.
bool has_tetgen() noexcept;

/// Tetrahedra between the surface's vertices (numbers 0 .. n-1), the seeds inside the domain, and the few points that
/// TetGen had to add inside (n, n+1, ...). Every surface triangle is a face of exactly one tetrahedron.
struct Volume {
  std::vector<Vec3> added;                    ///< coordinates of the vertices from n on
  std::vector<std::uint8_t> added_is_seed;    ///< 1 for a seed, 0 for TetGen's own point
  std::vector<std::array<GlobalId, 4>> tets;  ///< positive volume (TetMesh's orientation)
};

/// Fills the closed surface. `seeds`: points to be used inside; those outside the domain are dropped, and none
/// may lie on the surface. Throws Error(kInvalidMesh) when the surface cuts itself, naming triangles, and Error(kUsage)
/// when Skein was built without TetGen.
Volume fill_volume(const ClosedSurface& surface, const std::vector<Vec3>& seeds);

}  // namespace skein
