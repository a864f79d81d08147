// Steps towards a metric that asks for elements far more stretched than those of the mesh.
#include "adapt/stretch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/tensor.hpp"
#include "comm/halo.hpp"
#include "metric/mesh_metric.hpp"

namespace skein {
namespace {

/// The edges of an element as the tensor half the sum of e e'. For an element with all edges of length 1 that is the
/// identity; its inverse is the metric in which all edges of this one have length 1.
SymTensor edge_tensor(const TetMesh& m, TetId t) noexcept {
  SymTensor s;
  for (const auto& k : kEdgeVerts) {
    const Vec3 e = m.coords[m.tet2vert[t][k[1]]] - m.coords[m.tet2vert[t][k[0]]];
    s = s + 0.5 * SymTensor{e.x * e.x, e.x * e.y, e.y * e.y, e.x * e.z, e.y * e.z, e.z * e.z};
  }
  return s;
}

/// log of the metric in which the element is a unit one. A flat element counts as one of 1e-7 times its length.
SymTensor log_own_metric(const TetMesh& m, TetId t) noexcept {
  constexpr double kFlat = 1e-14;
  Eigen e = eigen(edge_tensor(m, t));
  for (double& l : e.value) l = -std::log(std::max(l, kFlat * e.value[2]));
  return compose(e);
}

/// Pieces along the longest direction and how many times that is the mean of the other two directions.
struct Stretch {
  double pieces, ratio;
};
/// Of the element in the metric M of a vertex: the squares of its pieces are the eigenvalues of M S with S =
/// edge_tensor(). The largest one is their sum where it counts, the product is known from the volume.
Stretch stretch_of(const TetMesh& m, TetId t) noexcept {
  const auto& v = m.tet2vert[t];
  const VertMetric* g = &m.metric[v[0]];
  for (const VertId w : v) {
    if (m.metric[w].order_key > g->order_key) g = &m.metric[w];
  }
  double squares = 0;
  for (const auto& k : kEdgeVerts) squares += 0.5 * quad(g->m, m.coords[v[k[1]]] - m.coords[v[k[0]]]);
  const double pieces = std::sqrt(squares), product = std::sqrt(2.0) * std::abs(volume6(m, t)) * g->sqrt_det;
  return {pieces, pieces * std::sqrt(pieces / std::max(product, 1e-300))};
}

/// The log-metric of a step: `log_m` or a coarser one, in a mesh with the own metric `log_own`.
SymTensor bounded(const SymTensor& log_m, const SymTensor& log_own, const Method::Growth& o) noexcept {
  // In the frame where the mesh's own metric is the identity, eigenvalues are squares of pieces.
  Eigen e = eigen(congruence(exp(-0.5 * log_own), exp(log_m)));
  const double least = std::sqrt(std::max(e.value[0], 1.0)), longest = std::sqrt(std::max(e.value[2], 1.0));
  const double most = o.stretch_step * least;
  if (longest <= o.stretch_left || longest <= most) return log_m;
  for (double& l : e.value) l = std::min(l, most * most);
  return log(congruence(exp(0.5 * log_own), compose(e)));
}

}  // namespace

StretchToDo stretch_to_do(const Comm& comm, const DistMesh& dist, std::span<const double> elements, double bound) {
  const TetMesh& m = dist.mesh;
  double all = 0, stretched = 0, excess = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const Stretch s = stretch_of(m, t);
    all += elements[idx(t)];
    if (s.pieces <= bound || s.ratio <= bound) continue;
    stretched += elements[idx(t)];
    excess += elements[idx(t)] * std::log(std::min(s.pieces, s.ratio) / bound);
  }
  all = std::max(comm.sum(all), 1e-300);
  stretched = comm.sum(stretched);
  return {stretched, stretched / all, comm.sum(excess) / all};
}

void bound_stretch(const Comm& comm, DistMesh& dist, const Method::Growth& method) {
  const TetMesh& m = dist.mesh;
  constexpr int kWidth = 7;  // per vertex: the sum of its elements' own log-metrics, and their number
  std::vector<double> sums(kWidth * m.vert_slots(), 0.0);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const SymTensor l = log_own_metric(m, t);
    for (const VertId v : m.tet2vert[t]) {
      double* s = sums.data() + kWidth * idx(v);
      for (const double x : {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz, 1.0}) *s++ += x;
    }
  }
  Halo(comm, dist.sharing).sum(std::span<double>(sums), kWidth);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const double* s = sums.data() + kWidth * idx(v);
    if (s[6] <= 0) continue;
    SymTensor& l = dist.mesh.log_metric[v];
    l = bounded(l, (1 / s[6]) * SymTensor{s[0], s[1], s[2], s[3], s[4], s[5]}, method);
  }
}

}  // namespace skein
