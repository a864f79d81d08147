// Set-up of a part, and its vertices.
#include "kernel/part.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "metric/complexity.hpp"

namespace skein {

double quality_cubed(const Part& p, TetId t) noexcept {
  const auto& v = p.mesh.tet2vert[t];
  return p.quality_cubed(v[0], v[1], v[2], v[3]);
}

void prepare(Part& p) {
  SKEIN_ASSERT_NO_FAULT_AT(2, check_sizes(p.mesh));
  SKEIN_ASSERT_NORMAL(p.mesh.log_metric.size() == p.mesh.vert_slots());
  SKEIN_ASSERT_NORMAL(p.mesh.metric.size() == p.mesh.vert_slots());
  const std::size_t nt = p.mesh.tet_slots();
  p.q3.resize(nt);
  p.tet_mark.assign(nt, 0);
  p.refused.assign(nt, 0);
  p.vert_mark.assign(p.mesh.vert_slots(), 0);
  p.edge_class.assign(p.mesh.vert_slots(), 0);
  p.tet_stamp = p.vert_stamp = 0;
  p.closest_new = p.options.method.lengths.closest_new;
  p.free_tets.clear();
  p.free_verts.clear();
  p.dirty.assign(nt, kFromTheStart);
  p.edges.assign(nt, {});
  for (const TetId t : IdRange<TetId>(nt)) {
    if (p.mesh.is_live(t)) {
      if (!p.active(t)) p.dirty[t] = 0;  // no pass looks at it
      p.q3[t] = static_cast<float>(quality_cubed(p, t));
      p.edges[t] = p.classify_edges(t);
      if (p.options.only_retry() && !p.has_any(t, kRetry)) p.dirty[t] = 0;
    } else {
      p.free_tets.push_back(t);
    }
  }
  find_special_features(p);
}

void find_special_features(Part& p) {
  p.contacts.find(p.mesh);
  p.has_required_tets =
      std::any_of(p.mesh.tet_class.begin(), p.mesh.tet_class.end(), [](TetClass c) { return any(c & kRequiredTet); });
  p.has_thin =
      std::any_of(p.mesh.vert_class.begin(), p.mesh.vert_class.end(), [](VertClass c) { return any(c & kThin); });
}

std::int64_t expected_points(const TetMesh& m) {
  const double complexity = complexity_of(m, [&](VertId v) { return m.metric[v].sqrt_det; });
  return static_cast<std::int64_t>(kVertsPerComplexity * complexity) + 1000;
}

void reserve(Part& p, std::size_t points) {
  // Memory that is not touched costs nothing, so half as much again; up to a size where a wrong metric would ask for
  // more than there is.
  constexpr std::size_t kMost = 16'000'000, kTetsPerVert = 6;
  const std::size_t nv = std::min(points + points / 2, kMost), nt = kTetsPerVert * nv;
  if (nv <= p.mesh.vert_slots()) return;
  p.mesh.reserve(nv, nt);
  p.vert_mark.reserve(nv);
  p.edge_class.reserve(nv);
  p.q3.reserve(nt);
  p.tet_mark.reserve(nt);
  p.refused.reserve(nt);
  p.dirty.reserve(nt);
  p.edges.reserve(nt);
}

IdVector<VertId, VertId> compact(Part& p) {
  IdVector<TetId, TetId> tets;
  auto verts = compact(p.mesh, &tets);
  const std::size_t nv = p.mesh.vert_slots(), nt = p.mesh.tet_slots();
  permute(p.q3, tets, nt);
  permute(p.dirty, tets, nt);
  permute(p.edges, tets, nt);
  p.tet_mark.assign(nt, 0);
  p.refused.assign(nt, 0);
  p.vert_mark.assign(nv, 0);
  p.edge_class.assign(nv, 0);
  p.tet_stamp = p.vert_stamp = 0;
  p.free_tets.clear();
  p.free_verts.clear();
  if (!p.contacts.empty()) p.contacts.find(p.mesh);
  return verts;
}

namespace {
SymTensor with_spacing(const Part& p, Vec3 x, const SymTensor& log_m) noexcept {
  if (p.spacing == nullptr) return log_m;
  const double h = p.spacing->at(x);
  const SymTensor m = exp(log_m), want = isotropic(1 / (h * h));
  // Isotropic metrics are intersected by taking the larger one; only true anisotropy needs the reduction.
  if (std::abs(m.xy) + std::abs(m.xz) + std::abs(m.yz) + std::abs(m.xx - m.yy) + std::abs(m.xx - m.zz) < 1e-9 * m.xx) {
    return m.xx >= want.xx ? log_m : isotropic(std::log(want.xx));
  }
  return log(intersect(m, want));
}
}  // namespace

namespace {
/// A free slot, or a new one at the end, with nothing in it.
VertId free_slot(Part& p) {
  TetMesh& m = p.mesh;
  if (!p.free_verts.empty()) {
    const VertId v = p.free_verts.back();
    p.free_verts.pop_back();
    clear_entries(m, v);
    m.vert2tet[v] = kNoTet;
    return v;
  }
  append_entries(m);
  m.vert2tet.push_back(kNoTet);
  p.edge_class.push_back(0);
  return p.vert_mark.push_back(0);
}
}  // namespace

VertId new_vertex(Part& p, Vec3 x, const SymTensor& log_m, VertClass vert_class, VertState state) {
  const SymTensor l = with_spacing(p, x, log_m);
  TetMesh& m = p.mesh;
  const VertId v = free_slot(p);
  m.coords[v] = x;
  m.vert_class[v] = vert_class;
  m.vert_state[v] = state | kActive;
  set_log_metric(m, v, l);
  if (!m.anchor.empty()) m.anchor[v] = {x, l};
  if (!m.surface_place.empty()) m.surface_place[v] = SurfacePlace::kUnknown;
  return v;
}

void drop_vertex(Part& p, VertId v) {
  p.mesh.vert2tet[v] = kNoTet;
  p.mesh.vert_class[v] = {};
  p.mesh.vert_state[v] = {};
  p.free_verts.push_back(v);
}

}  // namespace skein
