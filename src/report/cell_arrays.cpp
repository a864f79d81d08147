// Arrays for pictures.
#include "report/cell_arrays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "dist/gather_slices.hpp"
#include "metric/measure.hpp"
#include "report/slice_coordinates.hpp"

namespace skein {
namespace {

using Corners = std::array<Vec3, 4>;

/// Longest edge over shortest height, and the smallest dihedral angle (degrees).
std::pair<double, double> shape(const Corners& x) noexcept {
  std::array<Vec3, 4> n;  // outward, as long as twice the area
  double longest = 0, largest = 0, angle = 180;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& f = kFaceVerts[k];
    n[k] = cross(x[f[1]] - x[f[0]], x[f[2]] - x[f[0]]);
    largest = std::max(largest, norm(n[k]));
  }
  for (const auto& [a, b] : kEdgeVerts) {
    longest = std::max(longest, norm(x[b] - x[a]));
    const double c = dot(normalized(n[a]), normalized(n[b]));
    angle = std::min(angle, 180 - 180 / std::numbers::pi * std::acos(std::clamp(c, -1.0, 1.0)));
  }
  const double volume6 = std::abs(dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])));
  constexpr double kRegular = 0.81649658092772603;  // sqrt(2/3), the height of the regular one
  return {volume6 > 0 ? kRegular * longest * largest / volume6 : std::numeric_limits<double>::infinity(), angle};
}

FieldSlice named(std::int64_t total, std::int64_t first) {
  FieldSlice f;
  f.total = total, f.first = first, f.width = kCellArrays;
  f.kinds.assign(kCellArrays, FieldKind::kScalar);
  f.names = {"quality", "edge_length", "aspect_ratio", "min_dihedral", "part"};
  return f;
}

void add(FieldSlice& f, const Corners& x, const std::array<VertMetric, 4>& m, int part) {
  double length = 0;
  for (const auto& [a, b] : kEdgeVerts) length += edge_length(m[a].m, m[b].m, x[b] - x[a]) / 6;
  const auto [aspect, angle] = shape(x);
  const double q = quality(quality_cubed(x[0], x[1], x[2], x[3], m[0], m[1], m[2], m[3]));
  f.values.insert(f.values.end(), {q, length, aspect, angle, static_cast<double>(part)});
}

}  // namespace

FieldSlice cell_arrays(const Comm& comm, const DistMesh& dist, Measure measure) {
  const TetMesh& m = dist.mesh;
  const auto own = static_cast<std::int64_t>(m.tet_slots());
  FieldSlice f = named(comm.sum(own), comm.exclusive_sum(own));
  IdVector<VertId, VertMetric> metric(m.vert_slots(), vert_metric(isotropic(1)));
  for (const VertId v : IdRange<VertId>(measure == Measure::kInMetric ? m.vert_slots() : 0)) {
    metric[v] = vert_metric(exp(m.log_metric[v]));
  }
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& v = m.tet2vert[t];
    add(f, {m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]]},
        {metric[v[0]], metric[v[1]], metric[v[2]], metric[v[3]]}, num(comm.rank()));
  }
  return f;
}

FieldSlice cell_arrays(const Comm& comm, const MeshSlice& mesh) {
  const SliceCoordinates x(comm, mesh, mesh.tets.verts, nullptr);
  FieldSlice f = named(mesh.tets.total, mesh.tets.first);
  const VertMetric space = vert_metric(isotropic(1));
  for (const auto& v : mesh.tets.verts) {
    add(f, {x[v[0]], x[v[1]], x[v[2]], x[v[3]]}, {space, space, space, space}, num(comm.rank()));
  }
  return f;
}

FieldSlice with_metric_arrays(const Comm& comm, const DistMesh& dist, FieldSlice fields) {
  FieldSlice logs = to_metric_slices(comm, dist);
  FieldSlice out;
  out.total = logs.total, out.first = logs.first;
  out.kinds = fields.kinds, out.names = fields.names;
  out.names.resize(out.kinds.size());
  out.kinds.insert(out.kinds.end(), {FieldKind::kScalar, FieldKind::kTensor});
  out.names.insert(out.names.end(), {"size", "metric"});
  out.width = fields.width + 7;
  const auto width = static_cast<std::size_t>(fields.width);
  for (std::size_t v = 0; 6 * v + 6 <= logs.values.size(); ++v) {
    const double* const l = logs.values.data() + 6 * v;
    const SymTensor log_m{l[0], l[1], l[2], l[3], l[4], l[5]};
    const SymTensor m = exp(log_m);
    out.values.insert(out.values.end(), fields.values.data() + v * width, fields.values.data() + (v + 1) * width);
    out.values.insert(out.values.end(), {std::exp(-log_sqrt_det(log_m) / 3), m.xx, m.xy, m.yy, m.xz, m.yz, m.zz});
  }
  return out;
}

}  // namespace skein
