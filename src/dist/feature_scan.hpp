// The feature edges that are edges of tetrahedra.
#pragma once
#include <array>
#include <cstdint>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// Calls found(place in features.list()) for each edge of tetrahedron t that is a feature edge. @pre there are any.
template <class Found>
void features_of(const TetMesh& m, TetId t, Found&& found) {
  const auto& v = m.tet2vert[t];
  std::array<bool, 4> marked{};
  int n = 0;
  for (std::size_t k = 0; k < 4; ++k) n += (marked[k] = m.has(v[k], kRidge | kCorner)) ? 1 : 0;
  if (n < 2) return;
  for (const auto& e : kEdgeVerts) {
    const auto a = e[0], b = e[1];
    if (!marked[a] || !marked[b]) continue;
    const FeatureEdge* edge = m.features.find(v[a], v[b]);
    if (edge != nullptr) found(static_cast<std::uint32_t>(edge - m.features.list().data()));
  }
}

/// Calls found(tet, place in features.list()) for each edge of each tetrahedron that is a feature edge.
template <class Found>
void for_each_feature(const TetMesh& m, Found&& found) {
  if (m.features.size() == 0) return;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    features_of(m, t, [&](std::uint32_t edge) { found(t, edge); });
  }
}

}  // namespace skein
