// Volume generation from a closed surface triangulation [HassanProbert1999, 35.2.3].
#pragma once
#include "adapt/adapt.hpp"
#include "comm/comm.hpp"
#include "comm/phase_log.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "metric/spacing.hpp"

namespace skein {

struct GenerateOptions {
  SpacingField sources;     ///< the strictest of these and of the boundary spacing holds
  double size_max = 1e300;  ///< largest spacing anywhere; length
  double growth = 0.3;      ///< how fast the boundary spacing may grow inwards: spacing gained per distance
  double ridge_angle = 45;  ///< surface edges folded more than this are ridges; degrees
  /// What may happen to the surface triangulation. It stays as it is unless sizes are given, which may ask for more.
  enum class Surface { kKeptUnlessSizesAreGiven, kKept, kRemeshed };
  Surface surface = Surface::kKeptUnlessSizesAreGiven;
  [[nodiscard]] bool keeps_surface() const noexcept {
    const bool sizes = !sources.sources.empty() || sources.size_max < 1e300 || size_max < 1e300;
    return surface == Surface::kKept || (surface == Surface::kKeptUnlessSizesAreGiven && !sizes);
  }
  AdaptOptions adapt;  ///< surface and spacing are set by generate()
};

/// A first, coarse volume mesh: TetGen's tetrahedra between the surface vertices and a few points inside (seeds).
struct CoarseVolume {
  MeshSlice mesh;               ///< even slices; the surface's vertices, triangles, edges and lists first and unchanged
  std::vector<double> spacing;  ///< wanted, per vertex of this rank's slice; length
  double surface_volume = 0;    ///< enclosed by the surface; length^3; the same on every rank
};

/// Collective. Checks the surface and fills it (rank 0 alone holds the surface and TetGen's result, for a moment).
/// Throws on all ranks as check_surface() and fill_volume() do.
CoarseVolume fill_surface(const Comm& comm, const MeshSlice& surface, const GenerateOptions& options, PhaseLog& log);

/// Collective. The volume mesh with the wanted spacing. It has the column log_metric (isotropic).
DistMesh generate(const Comm& comm, const MeshSlice& surface, const GenerateOptions& options, PhaseLog& log);

}  // namespace skein
