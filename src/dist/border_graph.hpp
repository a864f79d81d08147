// The dual graph of the tetrahedra near the interfaces.
#pragma once
#include <limits>
#include <span>
#include <vector>

#include "dist/interface_faces.hpp"
#include "partition/graph.hpp"

namespace skein {

/// Node i is tetrahedron tets[i]. If `core`, there is one more node: all other tetrahedra of the rank together.
struct BorderGraph {
  DistGraph dist;
  std::vector<TetId> tets;  ///< ascending
  bool core = false;
};

/// Collective. The graph of the tetrahedra near the interfaces of this rank. They are found layer by layer, over faces,
/// from the interface inwards: those on the interface, and behind the interface with rank r until the work of these
/// layers is reach[r], or there are no more. With kWholeRank for all ranks these are all tetrahedra. Weights are those
/// of dual_graph(). @pre as dual_graph(); `faces` as match_interface() gives them; one entry of `reach` for each rank.
BorderGraph border_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                         const std::vector<InterfaceFace>& faces, std::span<const double> reach);
inline constexpr double kWholeRank = std::numeric_limits<double>::max();

}  // namespace skein
