// The reference surface on the way of an adaptation.
#include "api/on_surface.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/text.hpp"

namespace skein {
namespace {

constexpr double kRounding = 1e-9;

void note_surface(PhaseLog& log, const SurfaceReport& report) {
  const PatchDeviation all = report.total();
  if (all.largest <= kRounding * std::sqrt(all.area)) return;  // all flat
  log.note(fmt::format("surface: off by at most {:.3g} and {:.3g} on average, near ({:.6g}, {:.6g}, {:.6g})",
                       all.largest, all.mean(), report.worst.x, report.worst.y, report.worst.z));
  if (all.vertices_off == 0) return;
  const auto off = static_cast<std::int64_t>(all.vertices_off);
  log.note(fmt::format(
      "note: {} vertices of the boundary could not be moved onto the surface; the farthest is off by {:.3g}",
      grouped(off), all.largest_vertex));
}

/// Makes the surface of a boundary.
ReferenceSurface make_surface(const BoundarySurface& boundary, const AdaptationOptions& options) {
  ReferenceSurface surface(boundary.input, options.geometry);
  surface.limit_deviation(options.deviation.share, options.deviation.thickness_share, boundary.most);
  return surface;
}

/// Collective. The surface of the mesh itself.
ReferenceSurface own_surface(const Comm& comm, DistMesh& dist, const AdaptationOptions& options, Invariants& before) {
  const BoundarySurface boundary = gather_boundary(comm, dist, options.deviation);
  std::optional<ReferenceSurface> surface;
  agree(comm, [&] {
    surface.emplace(make_surface(boundary, options));
    place_on_own_surface(dist, boundary, *surface);
    add_smooth(before, dist.mesh, boundary, *surface);
  });
  return std::move(*surface);
}

/// Collective. That of another mesh.
ReferenceSurface other_surface(const Comm& comm, DistMesh& dist, const MeshSlice& geometry,
                               const AdaptationOptions& options, Invariants& before) {
  const DistMesh original = distribute(comm, geometry, nullptr, options.distribute);
  const BoundarySurface boundary = gather_boundary(comm, original, options.deviation);
  Invariants of_original = invariants(comm, original);
  std::optional<ReferenceSurface> surface;
  agree(comm, [&] {
    surface.emplace(make_surface(boundary, options));
    add_smooth(of_original, original.mesh, boundary, *surface);
    expect_smooth(before, of_original);
  });
  place_on_other_surface(comm, dist, *surface, original.mesh.patch_ref);
  return std::move(*surface);
}

}  // namespace

std::optional<SurfaceReport> adapt_on_surface(const Comm& comm, DistMesh& dist, const MeshSlice& geometry,
                                              const AdaptationOptions& options, PhaseLog& log, Invariants& before,
                                              const std::function<void(const AdaptationOptions&)>& work) {
  if (!options.adapt.surface) {
    work(options);
    return {};
  }
  const auto finish = [&] { log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots())); };
  log.start("surface");
  const ReferenceSurface surface = geometry.total_verts > 0 ? other_surface(comm, dist, geometry, options, before)
                                                            : own_surface(comm, dist, options, before);
  finish();
  AdaptationOptions on_surface = options;
  on_surface.adapt.reference = &surface;
  work(on_surface);
  log.start("surface report");
  SurfaceReport report = surface_report(comm, dist, surface);
  dist.mesh.surface_place = {};
  finish();
  note_surface(log, report);
  return report;
}

}  // namespace skein
