// Gradation: how fast sizes may grow from a vertex to its neighbours ([Alauzet2010]: Size gradation control of
// anisotropic meshes, Finite Elem. Anal. Des. 46, 2010: growth in the metric space). The local half, without MPI.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/tensor.hpp"
#include "mesh/tet_mesh.hpp"

namespace skein {

/// The neighbours of each vertex along edges: those of v are vert[offset[v] .. offset[v+1]).
struct VertGraph {
  std::vector<std::uint32_t> offset;
  std::vector<VertId> vert;
  [[nodiscard]] std::span<const VertId> of(VertId v) const noexcept {
    return {vert.data() + offset[idx(v)], vert.data() + offset[idx(v) + 1]};
  }
};
/// The edges of the tetrahedra, each once in both directions; neighbours ascending by `gid`. @pre no free slots.
VertGraph vertex_graph(const TetMesh& mesh, const IdVector<VertId, GlobalId>& gid);

/// The metric at the other end of edge e that growth from m allows: m / (1 + l ln g)^2 with l the length of e in m, so
/// that every size of m grows by the factor 1 + l ln g (at most g per ideal edge, and for isotropic m by ln g times the
/// length of e, whatever l is).
SymTensor grown(const SymTensor& m, Vec3 e, double log_growth) noexcept;

/// Relative excess of eigenvalues that is taken as no violation: sizes within 0.05 %.
inline constexpr double kGradationTolerance = 1e-3;
/// True when m is at least as strict as `bound` in every direction, to kGradationTolerance: (1 + tolerance) m - bound
/// is positive definite. @pre both are positive definite.
bool is_within(const SymTensor& m, const SymTensor& bound) noexcept;

/// Lowers sizes until size(w) <= size(v) + slope * |vw| for every edge vw reached, beginning at the vertices of
/// `changed` (Dijkstra): the largest such sizes that are nowhere above those given; the same for any order. Afterwards
/// `changed` holds the vertices whose size became less, ascending. @pre sizes > 0, slope >= 0.
void grade_sizes(const VertGraph& graph, const IdVector<VertId, Vec3>& coords, double slope, std::span<double> size,
                 std::vector<VertId>& changed);

}  // namespace skein
