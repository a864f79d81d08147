// MeshSlice: what one rank reads of a mesh file, or gives to one: an even slice of every entity list.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "base/vec3.hpp"

namespace skein {

/// N-vertex entities; vertices by global number from 0.
template <std::size_t N>
struct EntitySlice {
  std::int64_t total = 0;  ///< in the file
  std::int64_t first = 0;  ///< number (from 0) of this rank's first
  std::vector<std::array<GlobalId, N>> verts;
  std::vector<std::int32_t> ref;
};
struct VertexListSlice {
  std::int64_t total = 0, first = 0;
  std::vector<GlobalId> verts;  ///< for ridges and required edges, triangles, tetrahedra: entity numbers from 0
};

/// A rank's even slices (comm/file.hpp, even_slice) of the entities of a mesh file. Nothing is checked but counts,
/// numbers in range and finite coordinates.
struct MeshSlice {
  std::string path;
  std::int64_t first_number = 1;  ///< of a vertex or an entity in messages: files count from 1
  std::int64_t total_verts = 0, first_vert = 0;
  std::vector<Vec3> coords;
  std::vector<std::int32_t> vert_ref;
  EntitySlice<2> edges;
  EntitySlice<3> triangles;
  EntitySlice<4> tets;
  VertexListSlice corners;               ///< vertex numbers
  VertexListSlice ridges;                ///< edge numbers
  VertexListSlice required_verts;        ///< vertex numbers
  VertexListSlice required_edges;        ///< edge numbers
  VertexListSlice required_triangles;    ///< triangle numbers
  VertexListSlice required_tets;         ///< tetrahedron numbers
  std::vector<std::string> passed_over;  ///< sections of the file that are not kept, by name; on rank 0
};

enum class FieldKind : std::int32_t { kScalar = 1, kVector = 2, kTensor = 3 };
constexpr int components(FieldKind k) noexcept { return k == FieldKind::kScalar ? 1 : k == FieldKind::kVector ? 3 : 6; }

/// A rank's even slice of the values at the vertices of a solution file: several fields side by side.
struct FieldSlice {
  std::string path;
  std::int64_t first_number = 1;  ///< of a vertex in messages
  std::int64_t total = 0, first = 0;
  std::vector<FieldKind> kinds;
  int width = 0;                   ///< sum of components; symmetric tensors in Medit order m11 m12 m22 m13 m23 m33
  std::vector<double> values;      ///< width numbers per vertex, vertex after vertex
  std::vector<std::string> names;  ///< for .vtu and .pvtu; field0, field1, ... where there is none
};

}  // namespace skein
