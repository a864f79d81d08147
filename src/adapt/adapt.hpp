// The rounds: adapt every part with its interface frozen, then move the interfaces.
#pragma once
#include <functional>

#include "comm/comm.hpp"
#include "comm/phase_log.hpp"
#include "dist/dist_mesh.hpp"
#include "geometry/reference_surface.hpp"
#include "kernel/method.hpp"
#include "metric/spacing.hpp"

namespace skein {

struct AdaptOptions {
  int rounds = 3;   ///< rounds over the ranks; later ones work only round the old interfaces
  int threads = 1;  ///< threads in each rank
  Method method;
  bool surface = true;  ///< boundary faces may change (false: the boundary triangulation is kept as it is)
  /// The surface that the boundary stands for (not owned); the mesh then has its column surface_place. Null: the facets
  /// as they are, and deviations from them add up from operation to operation.
  const ReferenceSurface* reference = nullptr;
  const SpacingField* spacing =
      nullptr;  ///< evaluated at every new vertex and intersected with the interpolated metric
  /// Collective. Called once when a mesh that was too small has grown in steps, before the first round: on this finer
  /// mesh it can be told what the metric really asks for, and log_metric may be scaled.
  std::function<void(DistMesh&)> grown;
};

/// Collective. Adapts the mesh to the metric whose logarithm is the column log_metric. The result is compact, has equal
/// numbers of tetrahedra (4 %) on all ranks, and is checked by reconcile(); new vertices have an interpolated
/// log_metric and zeros in `fields`.
void adapt(const Comm& comm, DistMesh& dist, const AdaptOptions& options, PhaseLog& log);

}  // namespace skein
