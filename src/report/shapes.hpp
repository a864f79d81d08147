// Euler characteristic and pieces of the patches, of the hull and of the feature edges.
#pragma once
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "report/invariants.hpp"

namespace skein {

struct ShapesFound {
  std::vector<Shape> shapes;   ///< of each patch, of the hull, of all feature edges
  std::vector<double> folded;  ///< per patch: 1 where two of its facets are turned by more than kStraight, else 0
};

/// Collective. `faces` and `edges`: each on one rank (faces_to_write, edges_to_write). Only their vertices and edges
/// are looked at; those that several ranks may have meet by a rendezvous. Of pieces only their labels travel.
ShapesFound find_shapes(const Comm& comm, const DistMesh& dist, const std::vector<FaceId>& faces,
                        const std::vector<FeatureEdge>& edges);

}  // namespace skein
