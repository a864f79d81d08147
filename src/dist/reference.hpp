// The reference surface of a distributed mesh: its boundary as it is now, on every rank.
#pragma once
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "geometry/reference_surface.hpp"

namespace skein {

/// How far facets may be off the reference surface where sizes ask for coarser ones.
struct DeviationLimits {
  double share = 0.001;  ///< of the bounding box of each smooth piece of the surface
  /// Of volume over area of the regions beside it, and of area over rim of the piece: so thin bodies keep their volume,
  /// and narrow pieces their area. 0: no such limit.
  double thickness_share = 0.01;
};

/// The boundary of a mesh and what is on both sides of it.
struct BoundarySurface {
  SurfaceInput input;
  /// Per triangle: the regions behind it (against its normal) and before it; with a flag whether there is one.
  struct Sides {
    std::int32_t behind = 0, before = 0;
    std::int32_t has_before = 0;
  };
  std::vector<Sides> sides;
  std::vector<std::int64_t> edge_key;  ///< per feature edge: 256 * reference + class
  std::vector<double> most;            ///< per triangle: what thickness_share allows
  std::vector<GlobalId> points;        ///< ascending: global ids of the input's points
};

/// Collective. All tagged faces of the mesh and the feature edges on them, on every rank, in an order that does not
/// depend on the ranks. Memory: about 100 bytes per triangle. @pre dist is compact
BoundarySurface gather_boundary(const Comm& comm, const DistMesh& dist, const DeviationLimits& limits);

/// Fills the column surface_place of a mesh whose boundary the surface is made of. Not collective.
void place_on_own_surface(DistMesh& dist, const BoundarySurface& boundary, const ReferenceSurface& surface);
/// Collective. The same where the surface is that of another mesh: by the nearest point among the triangles of the same
/// patch reference. `patch_ref`: of the surface's patches. Throws Error(kInput) on all ranks, with a reference, when
/// the surface has no patch that a vertex is on.
void place_on_other_surface(const Comm& comm, DistMesh& dist, const ReferenceSurface& surface,
                            const std::vector<std::int32_t>& patch_ref);

}  // namespace skein
