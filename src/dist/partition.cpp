// Choice of the partitioner, predicted work and partition statistics.
#include "dist/partition.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/hilbert.hpp"
#include "base/union_find.hpp"
#include "dist/dual_graph.hpp"
#include "dist/interface_faces.hpp"
#include "metric/complexity.hpp"
#include "partition/hilbert.hpp"
#include "partition/multilevel.hpp"

namespace skein {

namespace {

/// Collective. The part of each tetrahedron: cut_keys on the Hilbert keys of the centroids.
IdVector<TetId, PartId> hilbert_partition(const Comm& comm, const DistMesh& dist, std::span<const double> tet_work,
                                          int parts) {
  const TetMesh& m = dist.mesh;
  const Box box = global_box(comm, m.coords.raw());
  std::vector<Vec3> centre(m.tet_slots());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    Vec3 sum;
    for (const VertId v : m.tet2vert[t]) sum += m.coords[v];
    centre[idx(t)] = 0.25 * sum;
  }
  std::vector<std::uint64_t> keys(m.tet_slots());
  hilbert_keys(centre, box, keys);
  return IdVector<TetId, PartId>(cut_keys(comm, keys, tet_work, parts));
}

}  // namespace

IdVector<TetId, PartId> multilevel_partition(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                             int parts, const MeshCutOptions& options) {
  DistGraph graph = dual_graph(comm, dist, work, options.face_weight, options.threads);
  auto part = multilevel_partition(comm, std::move(graph), parts,
                                   MultilevelOptions{.imbalance = options.imbalance, .threads = options.threads});
  return IdVector<TetId, PartId>(std::move(part.raw()));
}

IdVector<TetId, Rank> to_ranks(const IdVector<TetId, PartId>& part) {
  IdVector<TetId, Rank> rank(part.size());
  for (const TetId t : IdRange<TetId>(part.size())) rank[t] = rank_of(part[t]);
  return rank;
}

IdVector<TetId, PartId> partition(const Comm& comm, const DistMesh& dist, std::span<const double> tet_work, int parts,
                                  PartitionMethod method, int threads) {
  switch (method) {
    case PartitionMethod::kHilbert:
      return hilbert_partition(comm, dist, tet_work, parts);
    case PartitionMethod::kMultilevel:
      return multilevel_partition(comm, dist, tet_work, parts, {.threads = threads});
  }
  return {};
}

std::vector<double> predicted_elements(const TetMesh& m) {
  std::vector<double> elements(m.tet_slots(), 1.0);
  if (m.log_metric.empty()) return elements;
  const auto l = [&](VertId v) { return log_sqrt_det(m.log_metric[v]); };
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& v = m.tet2vert[t];
    elements[idx(t)] = tets_of_unit_mesh(vertex_face_rule({l(v[0]), l(v[1]), l(v[2]), l(v[3])}), volume6(m, t));
  }
  return elements;
}

namespace {

/// How far the metric with this logarithm is from an isotropic one: the length of the logarithm's deviator.
double anisotropy(const SymTensor& l) noexcept {
  const double mean = (l.xx + l.yy + l.zz) / 3, x = l.xx - mean, y = l.yy - mean, z = l.zz - mean;
  return std::sqrt(x * x + y * y + z * z + 2 * (l.xy * l.xy + l.xz * l.xz + l.yz * l.yz));
}

}  // namespace

std::vector<double> predicted_work(const TetMesh& m) {
  std::vector<double> work = predicted_elements(m);
  if (m.log_metric.empty()) return work;
  // Measured: 2.3 microseconds for each tetrahedron that is made, 1.7 for one that goes, 0.6 for one that stays.
  constexpr double kStays = 0.27, kGoes = 0.75;
  // What is made for a metric whose lengths differ by factors costs this much more than for an isotropic one.
  constexpr double kMore = 0.6;
  IdVector<VertId, double> made(m.vert_slots());
  for (const VertId v : IdRange<VertId>(made.size())) {
    made[v] = 1 + kMore * (1 - std::exp(-anisotropy(m.log_metric[v])));
  }
  for (const TetId t : IdRange<TetId>(work.size())) {
    double& w = work[idx(t)];
    const auto& v = m.tet2vert[t];
    w = w > 1 ? (made[v[0]] + made[v[1]] + made[v[2]] + made[v[3]]) / 4 * (w - 1) + kStays
              : kStays * w + kGoes * (1 - w);
  }
  return work;
}

namespace {

/// Pieces of the parts over all ranks: local pieces by joined sets; then the lowest number spreads over the interface.
std::int64_t count_components(const Comm& comm, const DistMesh& dist, const IdVector<TetId, PartId>& part,
                              const std::vector<InterfaceFace>& faces, const std::vector<PartId>& other_part) {
  const TetMesh& m = dist.mesh;
  UnionFind<TetId> sets(m.tet_slots());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (const FaceId f : m.tet2face[t]) {
      if (f != kNoFace && face_tet(f) < t && part[face_tet(f)] == part[t]) sets.join(t, face_tet(f));
    }
  }
  const auto first = comm.exclusive_sum(static_cast<std::int64_t>(m.tet_slots()));
  std::vector<std::int64_t> label(m.tet_slots());
  for (std::size_t t = 0; t < label.size(); ++t) label[t] = first + static_cast<std::int64_t>(t);
  std::int32_t changed = 1;
  while (comm.max(changed) != 0) {
    changed = 0;
    std::vector<std::int64_t> mine(faces.size());
    const auto label_at = [&](std::size_t i) -> std::int64_t& {
      return label[idx(sets.root(face_tet(faces[i].mine)))];
    };
    for (std::size_t i = 0; i < faces.size(); ++i) mine[i] = label_at(i);
    const auto theirs = swap_over_interface(comm, faces, mine);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (other_part[i] != part[face_tet(faces[i].mine)] || theirs[i] >= label_at(i)) continue;
      label_at(i) = theirs[i];
      changed = 1;
    }
  }
  std::int64_t count = 0;
  for (const TetId t : IdRange<TetId>(label.size())) {
    if (sets.root(t) == t && label[idx(t)] == first + num(t)) ++count;
  }
  return comm.sum(count);
}

}  // namespace

PartitionStats partition_stats(const Comm& comm, const DistMesh& dist, const IdVector<TetId, PartId>& part,
                               std::span<const double> tet_work, int parts) {
  const TetMesh& m = dist.mesh;
  PartitionStats stats;
  const auto faces = match_interface(comm, dist);
  std::vector<PartId> mine(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) mine[i] = part[face_tet(faces[i].mine)];
  const auto other_part = swap_over_interface(comm, faces, mine);
  std::int64_t cut = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) cut += mine[i] < other_part[i] ? 1 : 0;
  std::vector<double> work(static_cast<std::size_t>(parts), 0.0);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    work[idx(part[t])] += tet_work[idx(t)];
    for (const FaceId f : m.tet2face[t]) cut += f != kNoFace && face_tet(f) < t && part[face_tet(f)] != part[t] ? 1 : 0;
  }
  stats.cut_faces = comm.sum(cut);
  comm.reduce(std::span<double>(work), Op::kSum);
  const double total = std::accumulate(work.begin(), work.end(), 0.0);
  if (total > 0) stats.imbalance = *std::max_element(work.begin(), work.end()) * parts / total - 1;
  stats.components = count_components(comm, dist, part, faces, other_part);
  return stats;
}

}  // namespace skein
