// Size gradation on the edges of one rank.
#include "metric/gradation.hpp"

#include <algorithm>
#include <utility>

namespace skein {

VertGraph vertex_graph(const TetMesh& mesh, const IdVector<VertId, GlobalId>& gid) {
  const std::size_t n = mesh.vert_slots();
  // Every tetrahedron names each neighbour once: count, deal out, then drop what is named twice.
  std::vector<std::size_t> end(n + 1, 0);
  for (const auto& verts : mesh.tet2vert) {
    for (const VertId v : verts) end[idx(v) + 1] += 3;
  }
  for (std::size_t v = 0; v < n; ++v) end[v + 1] += end[v];
  std::vector<VertId> all(end[n]);
  std::vector<std::size_t> next(end.begin(), end.end() - 1);
  for (const auto& verts : mesh.tet2vert) {
    for (const VertId v : verts) {
      for (const VertId w : verts) {
        if (v != w) all[next[idx(v)]++] = w;
      }
    }
  }
  VertGraph graph;
  graph.offset.reserve(n + 1);
  graph.offset.push_back(0);
  std::size_t kept = 0;
  for (std::size_t v = 0; v < n; ++v) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(end[v]);
    auto last = all.begin() + static_cast<std::ptrdiff_t>(end[v + 1]);
    std::sort(first, last, [&](VertId a, VertId b) { return gid[a] < gid[b]; });
    last = std::unique(first, last);
    std::copy(first, last, all.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += static_cast<std::size_t>(last - first);
    graph.offset.push_back(static_cast<std::uint32_t>(kept));
  }
  graph.vert.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept));
  return graph;
}

SymTensor grown(const SymTensor& m, Vec3 e, double log_growth) noexcept {
  const double factor = 1 + std::sqrt(std::max(0.0, quad(m, e))) * log_growth;
  return (1 / (factor * factor)) * m;
}

bool is_within(const SymTensor& m, const SymTensor& bound) noexcept {
  const SymTensor d = (1 + kGradationTolerance) * m + -1.0 * bound;
  // Cholesky: all pivots positive.
  if (!(d.xx > 0)) return false;
  const double lxy = d.xy / d.xx, lxz = d.xz / d.xx;
  const double yy = d.yy - lxy * d.xy, yz = d.yz - lxy * d.xz;
  if (!(yy > 0)) return false;
  return d.zz - lxz * d.xz - yz / yy * yz > 0;
}

void grade_sizes(const VertGraph& graph, const IdVector<VertId, Vec3>& coords, double slope, std::span<double> size,
                 std::vector<VertId>& changed) {
  using Entry = std::pair<double, VertId>;
  const auto later = [](const Entry& a, const Entry& b) { return a > b; };
  std::vector<Entry> heap;
  heap.reserve(changed.size());
  for (const VertId v : changed) heap.emplace_back(size[idx(v)], v);
  std::make_heap(heap.begin(), heap.end(), later);
  changed.clear();
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), later);
    const auto [h, v] = heap.back();
    heap.pop_back();
    if (h > size[idx(v)]) continue;  // lowered since
    for (const VertId w : graph.of(v)) {
      const double most = h + slope * norm(coords[w] - coords[v]);
      if (most >= size[idx(w)]) continue;
      size[idx(w)] = most;
      changed.push_back(w);
      heap.emplace_back(most, w);
      std::push_heap(heap.begin(), heap.end(), later);
    }
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
}

}  // namespace skein
