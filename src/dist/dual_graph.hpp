// The dual graph of a mesh: a node for each tetrahedron, an edge for each face between two.
#pragma once
#include <cstdint>
#include <span>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "partition/graph.hpp"

namespace skein {

/// Collective. The dual graph. Edges weigh 1, or what face_weight says at FaceId (4 numbers >= 1 per tetrahedron, of
/// the two sides of a face the larger one counts); node weights are `work` scaled to integers, so that sums are exact
/// in any order. The same for any number of threads. @pre work: one finite number >= 0 per tetrahedron; dist is
/// compact.
DistGraph dual_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                     std::span<const std::int32_t> face_weight = {}, int threads = 1);

/// The same of one mesh by itself: what may be behind its faces without a neighbour does not count. Not collective.
DistGraph dual_graph(const TetMesh& mesh, std::span<const double> work, std::span<const std::int32_t> face_weight = {},
                     int threads = 1);

}  // namespace skein
