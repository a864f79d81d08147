// Check and repair of a surface triangulation before its volume is filled.
#pragma once
#include <vector>

#include "mesh/mesh_slice.hpp"

namespace skein {

/// A closed surface, whole (on one rank). Its triangles are oriented: counter-clockwise seen from outside the domain.
struct ClosedSurface {
  MeshSlice mesh;                     ///< whole, without tetrahedra; every vertex is used by a triangle
  std::vector<Vec3> voids;            ///< one point inside each void (hole) of the domain
  int shells = 0;                     ///< components (closed pieces) of the surface
  double volume = 0;                  ///< enclosed, length^3
  std::int64_t merged_verts = 0;      ///< vertices dropped because they had the coordinates of another
  std::int64_t unused_verts = 0;      ///< vertices dropped because no triangle uses them
  std::int64_t turned_triangles = 0;  ///< triangles whose orientation was changed
};

/// Merges vertices of bit-equal coordinates, drops unused ones and orients the triangles; a component inside another is
/// a void. Tetrahedra of the input are ignored. Throws Error(kInvalidMesh) with file, numbers (1-based as in the file)
/// and what is wrong: no triangles, degenerate or duplicate triangles, open edges, edges with more than two triangles,
/// coordinates that are not finite, one-sided surface.
/// @pre `whole` holds all entities (first numbers are 0).
ClosedSurface check_surface(MeshSlice whole);

}  // namespace skein
