// The whole way from slices to the adapted mesh: what the program and the library have in common.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "adapt/adapt.hpp"
#include "comm/comm.hpp"
#include "comm/phase_log.hpp"
#include "dist/dist_mesh.hpp"
#include "dist/distribute.hpp"
#include "dist/reference.hpp"
#include "mesh/mesh_slice.hpp"
#include "report/census.hpp"
#include "report/invariants.hpp"
#include "report/surface_report.hpp"
#include "solution/metric_policy.hpp"

namespace skein {

/// What is adapted, in slices.
struct AdaptationInput {
  MeshSlice mesh;
  FieldSlice values;     ///< at its vertices: what metric_values() gave (of kMesh nothing, of kField any number of
                         ///< scalars), then the numbers to be carried to the new mesh
  int carried = 0;       ///< how many of the numbers at a vertex are carried
  MeshSlice geometry{};  ///< a mesh whose boundary the geometry is; without vertices: that of `mesh`
};

/// How many there shall be in the result; 0: as many as the metric asks for. At most one is given, and then
/// MetricPolicy::complexity is complexity_for() of it.
struct WantedCount {
  double elements = 0, vertices = 0;
  [[nodiscard]] bool given() const noexcept { return elements > 0 || vertices > 0; }
};
/// The complexity whose unit mesh has about so many.
double complexity_for(const WantedCount& wanted) noexcept;

/// What a run tells of itself, beside the log.
struct AdaptationReport {
  EndCheckReport end_check;
  Census before;                         ///< of the input
  std::optional<SurfaceReport> surface;  ///< none where the boundary was to stay as it is
  double predicted_tets = 0;             ///< of the metric, before the work
  double complexity = 0;                 ///< of the metric, before the work
};

struct AdaptationOptions {
  DistributeOptions distribute;
  MetricPolicy metric;
  WantedCount wanted;
  SurfaceShape geometry = SurfaceShape::kPatches;  ///< how the boundary runs between the vertices of the input
  DeviationLimits deviation;
  AdaptOptions adapt;  ///< its `reference` is made on the way
  EndCheckLimits end_check;
  /// Collective. Gets the result when the end check finds it wrong, before the error: to write it as suspect, say.
  std::function<void(DistMesh&&)> suspect;
};

/// Collective. Compares the result with what `before` tells of the input. Throws Error(kInternal) on all ranks where
/// they differ by more than the limits, after options.suspect has had the mesh.
EndCheckReport end_check(const Comm& comm, const Invariants& before, DistMesh& dist, const AdaptationOptions& options);

/// Growth of sizes per edge when the user has not chosen one: none, but for sizes, which are often given roughly.
double usual_gradation(MetricSource source) noexcept;

/// The numbers of `a`, then those of `b`, vertex by vertex. @pre the same slice of vertices
FieldSlice side_by_side(FieldSlice a, const FieldSlice& b);

/// Collective. Distributes, makes the metric, adapts and carries the fields over; each is a phase of the log, and what
/// was found on the way a note. The input is freed as early as can be. The result has the logarithm of the metric in
/// its column log_metric, and the carried numbers in `fields`. `step_done` is told the name of each part of the way
/// when it is behind: "distribute", "adapt", "transfer" (if anything is carried). What the end check has
/// compared, and what there was before, comes into `report`.
DistMesh run_adaptation(const Comm& comm, AdaptationInput input, const AdaptationOptions& options, PhaseLog& log,
                        const std::function<void(const std::string&)>& step_done = {},
                        AdaptationReport* report = nullptr);

}  // namespace skein
