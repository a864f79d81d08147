// From the even slices of a file to a mesh in parts.
#pragma once
#include <cstdint>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

struct DistributeOptions {
  double ridge_angle = 45;   ///< degrees between the normals of two faces, above which their edge is a ridge
  double corner_angle = 45;  ///< degrees of bend between two ridge edges, above which their vertex is a corner
  /// The first 6 numbers of the fields are a log-metric (Medit order): they become the column log_metric, what is left
  /// becomes `fields`.
  bool metric_first = false;
  bool check_hull = true;         ///< look for faces of the hull that meet without being one
  bool work_from_metric = false;  ///< with metric_first: balance predicted work, not tetrahedra
};

/// What was found in the file; the same on every rank.
struct DistributeReport {
  std::int64_t untagged_hull_faces = 0;    ///< hull faces that no triangle of the file covers
  std::int64_t untagged_region_faces = 0;  ///< faces between tetrahedra of different reference without a triangle
  std::int64_t unused_verts = 0;           ///< vertices of no tetrahedron, dropped
  std::int64_t lost_edges = 0;             ///< edges of the file that are no edge of any tetrahedron, dropped
  std::int64_t found_ridges = 0;           ///< ridges that the file does not name
  std::int64_t turned_tets = 0;            ///< tetrahedra that were negatively oriented and have been turned
  std::int64_t double_tets = 0;            ///< tetrahedra given again, dropped
  std::int64_t double_triangles = 0;       ///< triangles given again, dropped
  std::int64_t double_edges = 0;           ///< edges given again, dropped
  std::int64_t crack_verts = 0;            ///< pairs of vertices at one place on matching sides of the hull (cracks)
};

/// Collective. The mesh of all ranks' slices, partitioned along the Hilbert curve; tetrahedra in Hilbert order,
/// vertices in the order of their first tetrahedron. Global ids are the vertex numbers of the file from 0 (unused
/// vertices leave gaps). `fields` (or null), at the same vertices in the same slices, becomes the column
/// `fields`.
///
/// Tags: a face with a triangle of the file gets its reference as patch; the hull without triangle becomes a patch of
/// its own with a new reference (highest + 1), faces between two tetrahedron references without triangle
/// another (the next one). Triangles between two tetrahedra tag both sides, without kHullFace. patch_ref is ascending.
/// Feature edges: those of the file (ridge if listed as such or as required), and the edges of tagged faces where not
/// exactly two meet, the patches differ, or the normals make more than ridge_angle: ridges with reference 0. Corners:
/// those of the file; vertices where feature edges end, branch, change reference or bend by more than corner_angle;
/// vertices where the tagged faces are not one fan. Ends of required edges become required. No vertex is marked
/// kActive; kFrozen is on the shared ones.
///
/// The order of the vertices of an entity carries no meaning: tetrahedra of negative volume are turned. What is given
/// again with the same reference is dropped, the one with the lowest number stays. An edge given with several
/// references keeps the lowest.
///
/// Throws on all ranks, naming up to five entities by their number in the file and how many there are:
/// Error(kInvalidMesh) for coordinates that are not finite, vertex numbers out of range, tetrahedra with a repeated
/// vertex, flat ones (volume exactly 0), tetrahedra and triangles given again with another reference, faces with more
/// than two tetrahedra or with two on one side, triangles that are no face; for what find_hull_contacts() and
/// find_nested() tell (check_hull): vertices inside faces or edges, faces that cover each other, overlapping
/// tetrahedra, vertices that are not merged. Error(kInput) when the fields do not fit the mesh.
DistMesh distribute(const Comm& comm, const MeshSlice& file, const FieldSlice* fields = nullptr,
                    const DistributeOptions& options = {}, DistributeReport* report = nullptr);

}  // namespace skein
