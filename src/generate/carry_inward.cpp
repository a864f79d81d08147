// Boundary spacing carried inward along the edges of the first tetrahedra, like distances in Dijkstra's algorithm.
#include "generate/carry_inward.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

namespace skein {
namespace {

using Edge = std::pair<GlobalId, GlobalId>;

template <class Entities>
std::vector<Edge> unique_edges(const Entities& entities) {
  std::vector<Edge> edges;
  for (const auto& e : entities) {
    for (std::size_t a = 0; a < e.size(); ++a) {
      for (std::size_t b = a + 1; b < e.size(); ++b) edges.push_back(std::minmax(e[a], e[b]));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Neighbours of every vertex: vert[offset[v] .. offset[v+1]).
struct Neighbours {
  std::vector<std::size_t> offset;
  std::vector<GlobalId> vert;
};

Neighbours neighbours(std::size_t verts, const std::vector<Edge>& edges) {
  Neighbours n{std::vector<std::size_t>(verts + 1, 0), std::vector<GlobalId>(2 * edges.size())};
  for (const auto& [a, b] : edges) {
    ++n.offset[idx(a) + 1];
    ++n.offset[idx(b) + 1];
  }
  for (std::size_t v = 0; v < verts; ++v) n.offset[v + 1] += n.offset[v];
  std::vector<std::size_t> next(n.offset.begin(), n.offset.end() - 1);
  for (const auto& [a, b] : edges) {
    n.vert[next[idx(a)]++] = b;
    n.vert[next[idx(b)]++] = a;
  }
  return n;
}

}  // namespace

std::vector<double> boundary_spacing(const MeshSlice& surface) {
  std::vector<double> sum(surface.coords.size(), 0);
  std::vector<std::int32_t> count(surface.coords.size(), 0);
  for (const auto& [a, b] : unique_edges(surface.triangles.verts)) {
    const double length = norm(surface.coords[idx(b)] - surface.coords[idx(a)]);
    for (const GlobalId v : {a, b}) {
      sum[idx(v)] += length;
      ++count[idx(v)];
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= count[v];
  return sum;
}

void carry_inward(std::span<const Vec3> coords, std::span<const std::array<GlobalId, 4>> tets, std::size_t fixed,
                  double growth, std::span<double> spacing) {
  const Neighbours near = neighbours(coords.size(), unique_edges(tets));
  using Item = std::pair<double, GlobalId>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  for (std::size_t v = 0; v < spacing.size(); ++v) queue.emplace(spacing[v], to_id<GlobalId>(v));
  while (!queue.empty()) {
    const auto [size, v] = queue.top();
    queue.pop();
    if (size > spacing[idx(v)]) continue;  // has become smaller since
    for (std::size_t i = near.offset[idx(v)]; i < near.offset[idx(v) + 1]; ++i) {
      const GlobalId u = near.vert[i];
      const double grown = size + growth * norm(coords[idx(u)] - coords[idx(v)]);
      if (idx(u) < fixed || !(grown < spacing[idx(u)])) continue;
      spacing[idx(u)] = grown;
      queue.emplace(grown, u);
    }
  }
}

}  // namespace skein
