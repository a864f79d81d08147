// The dual graph of what lies near the interfaces.
#pragma once
#include <span>
#include <vector>

#include "partition/graph.hpp"

namespace skein {

/// Nodes 0 .. tets.size()-1 are these tetrahedra; all others of the rank together are one more node behind them, if
/// `core`.
struct ShellGraph {
  DistGraph dist;
  std::vector<TetId> tets;  ///< ascending
  bool core = false;
};

/// Collective. The tetrahedra of this rank that come first from its interfaces inwards, over faces, until their work is
/// `reach` or there are no more; weights are those of dual_graph(). All tetrahedra where `reach` is as much as the
/// rank has. @pre as dual_graph().
ShellGraph shell_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work, double reach);

}  // namespace skein
