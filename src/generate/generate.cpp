// Volume generation: check, seeds, TetGen, then point creation by the rounds of the adaptation.
#include "generate/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dist/distribute.hpp"
#include "generate/carry_inward.hpp"
#include "generate/seeds.hpp"
#include "generate/slices.hpp"
#include "generate/surface_check.hpp"
#include "generate/tetgen_volume.hpp"

namespace skein {
namespace {

void check_options(const GenerateOptions& options) {
  const auto fail = [](const std::string& what) { throw Error(ExitCode::kUsage, what); };
  if (!(options.size_max > 0)) fail(fmt::format("size_max is {}, but must be greater than 0", options.size_max));
  if (!(options.growth > 0)) fail(fmt::format("growth is {}, but must be greater than 0", options.growth));
  if (!has_tetgen()) fill_volume({}, {});  // says what is missing before any work is done
}

SpacingField spacing_field(const GenerateOptions& options) {
  SpacingField field = options.sources;
  field.size_max = std::min(field.size_max, options.size_max);
  return field;
}

/// What rank 0 makes of the whole surface.
struct Whole {
  MeshSlice mesh;
  std::vector<double> spacing;
  double volume = 0;
  std::string note;
};

std::string describe(const ClosedSurface& s) {
  std::string text = fmt::format("surface: {} triangles, {} vertices, {} shell{}, {} void{}, volume {:.6g}",
                                 s.mesh.triangles.total, s.mesh.total_verts, s.shells, s.shells == 1 ? "" : "s",
                                 s.voids.size(), s.voids.size() == 1 ? "" : "s", s.volume);
  if (s.merged_verts > 0) text += fmt::format("; {} duplicate vertices merged", s.merged_verts);
  if (s.unused_verts > 0) text += fmt::format("; {} unused vertices dropped", s.unused_verts);
  return text;
}

Whole fill(MeshSlice gathered, const SpacingField& field, double growth) {
  Whole whole;
  ClosedSurface surface = check_surface(std::move(gathered));
  whole.spacing = boundary_spacing(surface.mesh);
  const double largest = *std::max_element(whole.spacing.begin(), whole.spacing.end());
  const std::size_t surface_verts = whole.spacing.size();
  const Volume volume = fill_volume(surface, make_seeds(surface.mesh, whole.spacing, field));

  whole.note = describe(surface);
  whole.mesh = std::move(surface.mesh);
  MeshSlice& mesh = whole.mesh;
  mesh.coords.insert(mesh.coords.end(), volume.added.begin(), volume.added.end());
  mesh.vert_ref.resize(mesh.coords.size(), 0);
  mesh.total_verts = static_cast<std::int64_t>(mesh.coords.size());
  mesh.tets.verts = volume.tets;
  mesh.tets.ref.assign(volume.tets.size(), 0);
  mesh.tets.total = static_cast<std::int64_t>(volume.tets.size());

  for (std::size_t v = 0; v < surface_verts; ++v) {
    whole.spacing[v] = std::min(whole.spacing[v], field.at(mesh.coords[v]));
  }
  for (const Vec3 x : volume.added) whole.spacing.push_back(std::min(largest, field.at(x)));
  carry_inward(mesh.coords, mesh.tets.verts, surface_verts, growth, whole.spacing);
  whole.volume = surface.volume;
  whole.note +=
      fmt::format("; {} seeds, {} first tetrahedra",
                  std::count(volume.added_is_seed.begin(), volume.added_is_seed.end(), 1), volume.tets.size());
  return whole;
}

/// Collective.
double hull_area(const Comm& comm, const TetMesh& m) {
  double sum = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (!is_hull(m.face_tag[t][k])) continue;
      const auto v = m.verts(make_face(t, k));
      sum += 0.5 * norm(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
    }
  }
  return comm.sum(sum);
}

/// Collective. What remeshing has done to the body.
void note_change(const Comm& comm, const TetMesh& m, double area, double volume, PhaseLog& log) {
  double now = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) now += volume6(m, t) / 6;
  now = comm.sum(now);
  log.note(fmt::format("the surface was remeshed: its area has changed by {:+.3g} %, the volume by {:+.3g} %",
                       100 * (hull_area(comm, m) / area - 1), 100 * (now / volume - 1)));
}

}  // namespace

CoarseVolume fill_surface(const Comm& comm, const MeshSlice& surface, const GenerateOptions& options, PhaseLog& log) {
  agree(comm, [&] { check_options(options); });
  const SpacingField field = spacing_field(options);
  log.start("fill surface");
  MeshSlice gathered = gather_surface(comm, surface);
  Whole whole;
  agree(comm, [&] {
    if (comm.is_root()) whole = fill(std::move(gathered), field, options.growth);
  });
  CoarseVolume coarse;
  coarse.mesh = scatter_mesh(comm, whole.mesh);
  coarse.spacing = scatter_values(comm, coarse.mesh.total_verts, 1, whole.spacing);
  coarse.surface_volume = comm.broadcast(whole.volume);
  log.note(whole.note);
  log.finish(static_cast<std::int64_t>(coarse.mesh.tets.verts.size()));
  return coarse;
}

DistMesh generate(const Comm& comm, const MeshSlice& surface, const GenerateOptions& options, PhaseLog& log) {
  const SpacingField field = spacing_field(options);
  CoarseVolume coarse = fill_surface(comm, surface, options, log);
  FieldSlice metric;
  metric.path = "spacing";
  metric.total = coarse.mesh.total_verts;
  metric.first = coarse.mesh.first_vert;
  metric.kinds = {FieldKind::kTensor};
  metric.width = 6;
  for (const double size : coarse.spacing) {
    const double l = -2 * std::log(size);  // logarithm of the isotropic metric 1/size^2
    metric.values.insert(metric.values.end(), {l, 0, l, 0, 0, l});
  }
  DistributeOptions distribute_options;
  distribute_options.ridge_angle = options.ridge_angle;
  distribute_options.metric_first = true;
  distribute_options.work_from_metric = true;
  log.start("distribute");
  DistMesh dist = distribute(comm, coarse.mesh, &metric, distribute_options);
  const double volume = coarse.surface_volume;
  coarse = {};
  log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  AdaptOptions adapt_options = options.adapt;
  adapt_options.surface = !options.keeps_surface();
  adapt_options.spacing = &field;
  if (options.surface == GenerateOptions::Surface::kKeptUnlessSizesAreGiven && options.keeps_surface())
    log.note("the surface triangulation is kept, as no sizes are given; --remesh-surface adapts it to its own spacing");
  const double area = hull_area(comm, dist.mesh);
  adapt(comm, dist, adapt_options, log);
  if (adapt_options.surface) note_change(comm, dist.mesh, area, volume, log);
  return dist;
}

}  // namespace skein
