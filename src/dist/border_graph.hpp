// The dual graph of what lies near the interfaces.
#pragma once
#include <limits>
#include <span>
#include <vector>

#include "dist/interface_faces.hpp"
#include "partition/graph.hpp"

namespace skein {

/// Nodes 0 .. tets.size()-1 are these tetrahedra; all others of the rank together are one more node behind them, if
/// `core`.
struct BorderGraph {
  DistGraph dist;
  std::vector<TetId> tets;  ///< ascending
  bool core = false;
};

/// Collective. The tetrahedra of this rank that come first from its interface faces inwards, over faces: those on the
/// interface, and behind the faces to rank r until their work is reach[r] or there are no more. Weights are those of
/// dual_graph(). All tetrahedra where all of `reach` is kWholeRank. @pre as dual_graph(); `faces` as match_interface()
/// gives them; one entry of `reach` for each rank.
BorderGraph border_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                         const std::vector<InterfaceFace>& faces, std::span<const double> reach);
inline constexpr double kWholeRank = std::numeric_limits<double>::max();

}  // namespace skein
