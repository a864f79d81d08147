// Faces of the hull of a file that meet without being one face.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"
#include "report/check.hpp"

namespace skein {

/// A face of one tetrahedron only.
struct LoneFace {
  std::array<GlobalId, 4> verts;  ///< of the face, ascending, then the opposite one
  std::int64_t tet = -1;
  std::int64_t odd = 0;        ///< 1: counter-clockwise from outside is an odd permutation of the ascending order
  std::int64_t triangles = 0;  ///< of the file, that are this face
};

/// Whether to look for tetrahedra inside others, which needs them all oriented.
enum class Nesting { kIgnore, kJudge };

/// Collective. What find_hull_contacts() and find_nested() tell of the faces, without coordinates; sets crack_verts.
std::vector<Finding> hull_findings(const Comm& comm, const MeshSlice& mesh, const std::vector<LoneFace>& lone,
                                   Nesting nesting, CheckResult& result);

}  // namespace skein
