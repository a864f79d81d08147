// Validity of a mesh file: what is wrong, how often, and where. Works on slices, so that any mesh that can be read can
// be judged, also one that is refused elsewhere.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"
#include "report/json.hpp"

namespace skein {

/// What can be wrong. The last three are warnings in a volume mesh, and so are all hull faces without a triangle where
/// there are no triangles at all; the others make a mesh invalid.
enum class Fault : std::int32_t {
  kNonpositiveTet,       ///< inverted or flat (or not finite)
  kDegenerateTet,        ///< names a vertex twice
  kDuplicateTet,         ///< the same four vertices as another
  kFaceOver2,            ///< a face of more than two tetrahedra
  kMisorientedPair,      ///< two tetrahedra that lie on the same side of their common face
  kHullFaceNotTriangle,  ///< a face of one tetrahedron that is not in the list of triangles
  kTriangleNotFace,      ///< a triangle that is no face of any tetrahedron
  kDuplicateTriangle,    ///< the same three vertices as another
  kOpenHullEdge,         ///< an edge of an odd number of hull faces
  kNonfiniteCoordinate,  ///< infinite or not a number
  kHangingVertex,        ///< inside a face or an edge of a tetrahedron that it does not belong to
  kCoveringFaces,        ///< two hull faces in one plane that overlap and are not the same
  kCrossingTets,         ///< two tetrahedra that overlap
  kUnmergedVertices,     ///< two vertices at one place whose faces are no crack
  kNestedTet,            ///< a tetrahedron inside others
  kNonmanifoldHullEdge,  ///< an edge of more than two hull faces (makes a surface mesh invalid)
  kUnusedVertex,         ///< of no tetrahedron
  kDuplicateVertex,      ///< the same coordinates as another
};
inline constexpr std::size_t kFaults = 18;
inline constexpr std::size_t kMaxFindings = 10;  ///< listed of each kind; all are counted

/// One thing that is wrong. Numbers from 0; -1 is "none".
struct Finding {
  Fault fault{};
  std::int32_t corners = 0;              ///< how many entries of `verts` are used
  std::int64_t entity = -1, other = -1;  ///< tetrahedra, triangles or vertices, as the fault says
  std::array<GlobalId, 4> verts{kNoGlobal, kNoGlobal, kNoGlobal, kNoGlobal};
  std::array<Vec3, 4> coords{};            ///< of `verts`
  [[nodiscard]] Vec3 at() const noexcept;  ///< the middle of the corners
};

struct CheckResult {
  bool valid = false;
  bool surface_only = false;  ///< no tetrahedra: the triangles are judged as a closed surface
  bool oriented = false;      ///< its triangles all face outwards, or all inwards
  std::int64_t vertices = 0, tets = 0, triangles = 0, hull_faces = 0, internal_triangles = 0;
  std::int64_t crack_verts = 0;                 ///< pairs of vertices at one place that are meant
  std::int64_t hull_euler = 0;                  ///< vertices - edges + faces of the hull
  double volume = 0, min_volume = 0, area = 0;  ///< length units of the file; of an oriented surface: what it encloses
  std::array<std::int64_t, kFaults> counts{};   ///< by Fault
  std::vector<Finding> findings;                ///< by Fault, then by entity number; at most kMaxFindings of each
};

/// Collective. The same on every rank (sums to rounding for any number of ranks). No rank ever holds the whole mesh.
CheckResult check_mesh(const Comm& comm, const MeshSlice& mesh);

/// The JSON key of a fault, e.g. "nonpositive_tets".
const char* key(Fault fault) noexcept;
std::string to_text(const CheckResult& result, const std::string& path);
Json to_json(const CheckResult& result);

}  // namespace skein
