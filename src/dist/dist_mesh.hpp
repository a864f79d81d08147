// DistMesh: the mesh in parts, one per rank.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "comm/halo.hpp"
#include "mesh/tet_mesh.hpp"
#include "metric/tensor.hpp"

namespace skein {

/// Numbers at the vertices that travel with them: `width` doubles per vertex, vertex after vertex (log-metric first,
/// then what else the caller keeps).
struct VertexData {
  int width = 0;
  std::vector<double> values;
  [[nodiscard]] double* at(VertId v) noexcept { return values.data() + idx(v) * static_cast<std::size_t>(width); }
  [[nodiscard]] const double* at(VertId v) const noexcept {
    return values.data() + idx(v) * static_cast<std::size_t>(width);
  }
};

/// One rank's part of a distributed mesh. Compact: no free slots. Each tetrahedron is on one rank; a vertex is on
/// every rank that has a tetrahedron at it. A local face without a neighbour and without kHullFace is on the
/// interface. patch_ref is the same on every rank. A feature edge is on every rank that has a tetrahedron with this
/// edge; other ranks with both of its vertices may have it, too.
struct DistMesh {
  TetMesh mesh;
  VertexData data;
  IdVector<VertId, GlobalId> vert2gid;
  Sharing sharing;                ///< the vertices that other ranks have, too
  std::int64_t global_verts = 0;  ///< over all ranks, shared ones once
  std::int64_t global_tets = 0;
};

/// The log-metric at a vertex. @pre the data begins with it
inline SymTensor log_metric_at(const DistMesh& dist, VertId v) noexcept {
  const double* d = dist.data.at(v);
  return {d[0], d[1], d[2], d[3], d[4], d[5]};
}

}  // namespace skein
