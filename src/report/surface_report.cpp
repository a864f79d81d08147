// Distances of the boundary to the reference surface.
#include "report/surface_report.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "dist/gather_slices.hpp"
#include "geometry/deviation.hpp"

namespace skein {
namespace {

constexpr double kRounding = 1e-6;  ///< of the longest edge at the facet: nearer than that is on the surface

/// The farthest point that this rank has seen.
struct Farthest {
  double distance = -1;
  Vec3 x;
};

void add_facet(const TetMesh& m, const ReferenceSurface& surface, FaceId f, PatchDeviation& sum, Farthest& farthest,
               IdVector<VertId, char>& seen) {
  const auto v = m.verts(f);
  const std::array x{m.coords[v[0]], m.coords[v[1]], m.coords[v[2]]};
  const Vec3 area = cross(x[1] - x[0], x[2] - x[0]);
  sum.area += 0.5 * norm(area);
  const double size = std::max({norm(x[1] - x[0]), norm(x[2] - x[1]), norm(x[0] - x[2])});
  const auto take = [&](double d, Vec3 at) {
    sum.largest = std::max(sum.largest, d);
    sum.sum += d;
    sum.samples += 1;
    if (d > farthest.distance) farthest = {d, at};
  };
  const Deviation of_facet = deviation(surface, x[0], x[1], x[2], place_near(m, v));
  sum.largest_angle = std::max(sum.largest_angle, std::acos(std::min(of_facet.cosine, 1.0)) * 180 / std::numbers::pi);
  take(of_facet.distance, (1.0 / 3) * (x[0] + x[1] + x[2]));
  for (std::size_t i = 0; i < 3; ++i) {
    if (seen[v[i]] != 0) continue;
    seen[v[i]] = 1;
    const SurfacePlace place = m.surface_place[v[i]];
    if (place == SurfacePlace::kUnknown) continue;  // a corner, which stays
    const double d = surface.distance(x[i], place);
    sum.largest_vertex = std::max(sum.largest_vertex, d);
    if (d > kRounding * size) sum.vertices_off += 1;
    take(d, x[i]);
  }
}

}  // namespace

PatchDeviation SurfaceReport::total() const {
  PatchDeviation all;
  for (const PatchDeviation& p : patches) {
    all.area += p.area, all.sum += p.sum, all.samples += p.samples, all.vertices_off += p.vertices_off;
    all.largest = std::max(all.largest, p.largest);
    all.largest_vertex = std::max(all.largest_vertex, p.largest_vertex);
    all.largest_angle = std::max(all.largest_angle, p.largest_angle);
  }
  return all;
}

SurfaceReport surface_report(const Comm& comm, const DistMesh& dist, const ReferenceSurface& surface) {
  const TetMesh& m = dist.mesh;
  SurfaceReport out;
  for (const std::int32_t ref : m.patch_ref) out.patches.push_back({.ref = ref});
  Farthest farthest;
  const std::vector<FaceId> faces = faces_to_write(comm, dist);
  agree(comm, [&] {
    IdVector<VertId, char> seen(m.vert_slots(), 0);
    for (const FaceId f : faces)
      add_facet(m, surface, f, out.patches[static_cast<std::size_t>(tag_patch(m.tag(f)))], farthest, seen);
  });
  std::vector<double> sums, most;
  for (const PatchDeviation& p : out.patches) {
    sums.insert(sums.end(), {p.area, p.sum, p.samples, p.vertices_off});
    most.insert(most.end(), {p.largest_vertex, p.largest, p.largest_angle});
  }
  comm.reduce(std::span<double>(sums), Op::kSum);
  comm.reduce(std::span<double>(most), Op::kMax);
  for (std::size_t i = 0; i < out.patches.size(); ++i) {
    PatchDeviation& p = out.patches[i];
    p.area = sums[4 * i], p.sum = sums[4 * i + 1], p.samples = sums[4 * i + 2], p.vertices_off = sums[4 * i + 3];
    p.largest_vertex = most[3 * i], p.largest = most[3 * i + 1], p.largest_angle = most[3 * i + 2];
  }
  Farthest best;
  for (const Farthest& f : comm.all_gather(farthest)) best = f.distance > best.distance ? f : best;
  out.worst = best.x;
  return out;
}

Json to_json(const SurfaceReport& report) {
  const auto json = [](const PatchDeviation& p) {
    return Json{{"area", p.area},
                {"largest_distance", p.largest},
                {"mean_distance", p.mean()},
                {"largest_vertex_distance", p.largest_vertex},
                {"largest_angle", p.largest_angle},
                {"vertices_off", static_cast<std::int64_t>(p.vertices_off)}};
  };
  Json out = json(report.total());
  out["worst"] = {report.worst.x, report.worst.y, report.worst.z};
  out["patches"] = Json::array();
  for (const PatchDeviation& p : report.patches) {
    Json patch = json(p);
    patch["ref"] = p.ref;
    out["patches"].push_back(patch);
  }
  return out;
}

}  // namespace skein
