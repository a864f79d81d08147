// From the parts back to slices of a file.
#pragma once
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// Collective. This rank's slice of each list of entities. Slices follow each other in rank order and differ in size.
/// Vertices: those it owns (the lowest rank of a shared one), in local order. Tetrahedra: its own. Triangles: each
/// tagged face once, with the patch's reference, counter-clockwise from outside; an internal one as seen from the
/// region of lower reference outward. Edges: each feature edge once; ridges, corners, required vertices and triangles
/// as lists.
/// @pre dist is compact and reconciled.
MeshSlice to_slices(const Comm& comm, const DistMesh& dist);

/// Collective. The tagged faces and the feature edges that this rank writes; over all ranks each is there once.
std::vector<FaceId> faces_to_write(const Comm& comm, const DistMesh& dist);
std::vector<FeatureEdge> edges_to_write(const Comm& comm, const DistMesh& dist);

/// Collective. The fields of the vertices, which are of these kinds, in the order of to_slices().
FieldSlice to_field_slices(const Comm& comm, const DistMesh& dist, const std::vector<FieldKind>& kinds);
/// Collective. The log-metric of the vertices, in the order of to_slices().
FieldSlice to_metric_slices(const Comm& comm, const DistMesh& dist);

}  // namespace skein
