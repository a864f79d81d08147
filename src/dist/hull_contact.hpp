// Faces of the hull that meet without being one face: where a mesh is not conforming, not merged, or overlaps.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/ids.hpp"
#include "base/vec3.hpp"
#include "comm/comm.hpp"

namespace skein {

/// A face of one tetrahedron only.
struct HullFace {
  std::array<GlobalId, 3> gid;  ///< counter-clockwise seen from outside
  std::array<Vec3, 3> x;
  std::int64_t tet = -1;    ///< number of the tetrahedron
  Vec3 inside;              ///< a point within the tetrahedron
  std::int64_t listed = 0;  ///< 1: a triangle of the file
};

enum class HullFaultKind : std::int32_t {
  kHanging,   ///< a vertex inside a face, or inside an edge, of a tetrahedron that it does not belong to
  kCovering,  ///< two tetrahedra with faces in one plane that overlap and are not the same
  kCrossing,  ///< two tetrahedra that overlap: an edge of one goes through a face of the other
  kUnmerged,  ///< two vertices at one place
  kNested,    ///< a tetrahedron inside others
};
inline constexpr std::size_t kHullFaultKinds = 5;

struct HullFault {
  HullFaultKind kind{};
  std::int32_t corners = 0;  ///< how many entries of `verts` are used
  std::int64_t number = -1;  ///< vertex (kHanging, kUnmerged) or tetrahedron
  std::int64_t other = -1;   ///< the other vertex or tetrahedron; -1 with kHanging and kNested
  std::array<GlobalId, 4> verts{kNoGlobal, kNoGlobal, kNoGlobal, kNoGlobal};
};

struct HullContacts {
  std::vector<HullFault> faults;  ///< each on one rank
  std::int64_t crack_verts = 0;   ///< over all ranks: pairs of vertices at one place that are meant, see below
};

/// Collective. Looks for contacts in the hull, of which each rank gives some faces. Only those meet that are near each
/// other: in cells of a grid with a level for each size of faces, on the rank of the cell. On a good mesh that takes
/// less than 1 % of an adaptation.
///
/// A crack is legal: two sides of the hull that match vertex by vertex and are triangles of the file. So vertices at
/// one place are a fault unless they are on such faces, or all faces at both are triangles of the file.
HullContacts find_hull_contacts(const Comm& comm, const std::vector<HullFace>& faces);

/// Collective. Pieces of the hull that lie inside of the mesh, one tetrahedron of each (kNested; each on one rank):
/// round a point within a tetrahedron the hull must wind once. @pre every face is seen counter-clockwise from outside
std::vector<HullFault> find_nested(const Comm& comm, const std::vector<HullFace>& faces);

}  // namespace skein
