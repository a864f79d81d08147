// How far the boundary of a mesh is off the reference surface, patch by patch.
#pragma once
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "geometry/reference_surface.hpp"
#include "report/json.hpp"

namespace skein {

/// Distances in the length unit of the mesh, angles in degrees.
struct PatchDeviation {
  std::int32_t ref = 0;         ///< reference of the patch
  double area = 0;              ///< of its facets
  double largest_vertex = 0;    ///< distance of a vertex to the surface
  double largest = 0;           ///< of vertices, middles of edges and centroids of facets
  double sum = 0, samples = 0;  ///< of these distances
  double largest_angle = 0;     ///< between the normal of a facet and that of the surface at its centroid
  double vertices_off = 0;      ///< how many are farther off than rounding explains
  [[nodiscard]] double mean() const noexcept { return samples > 0 ? sum / samples : 0; }
};
struct SurfaceReport {
  std::vector<PatchDeviation> patches;  ///< ascending by reference
  Vec3 worst{};                         ///< where the largest distance is
  [[nodiscard]] PatchDeviation total() const;
};

/// Collective. @pre the mesh has the column surface_place
SurfaceReport surface_report(const Comm& comm, const DistMesh& dist, const ReferenceSurface& surface);
Json to_json(const SurfaceReport& report);

}  // namespace skein
