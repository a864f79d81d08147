// TetMesh: one rank's (or one part's) tetrahedra as a struct of arrays.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/ids.hpp"
#include "base/vec3.hpp"
#include "mesh/feature_edges.hpp"
#include "mesh/vert_columns.hpp"

namespace skein {

/// Tag of one face of a tetrahedron: 0 is an inner face; otherwise the low 14 bits are the patch number (1-based
/// index into TetMesh::patch_ref, minus one) and the bits below tell more.
using FaceTag = std::uint16_t;
inline constexpr FaceTag kPatchMask = 0x3fff;
inline constexpr FaceTag kHullFace = 0x8000;      ///< face of the domain's hull: no tetrahedron behind it on any rank
inline constexpr FaceTag kRequiredFace = 0x4000;  ///< given as required triangle: kept as it is
constexpr int tag_patch(FaceTag t) noexcept { return static_cast<int>(t & kPatchMask) - 1; }
constexpr bool is_hull(FaceTag t) noexcept { return (t & kHullFace) != 0; }

/// The vertices of face f, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kFaceVerts{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
/// The two vertices of each of the six edges.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kEdgeVerts{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// What a tetrahedron is; a set of flags.
enum class TetClass : std::uint8_t {
  kRequiredTet = 1,  ///< given as required: kept as it is
};
using enum TetClass;
template <>
inline constexpr bool kIsFlagSet<TetClass> = true;

/// The flags of a vertex on such a feature edge.
constexpr VertClass class_on(FeatureClass edge) noexcept {
  return (any(edge & kThinEdge) ? kThin : VertClass{}) | (any(edge & kContactEdge) ? kContact : VertClass{});
}

/// Tetrahedra with adjacency. A tetrahedron is oriented so that det(v1-v0, v2-v0, v3-v0) > 0.
/// A free slot has tet2vert[t][0] == kNoVert; a free vertex has vert2tet == kNoTet.
/// A face with tet2face == kNoFace is on the hull (tag has kHullFace) or on the interface to another part.
struct TetMesh : VertColumns {
  IdVector<VertId, TetId> vert2tet;  ///< one tetrahedron at the vertex
  // per tetrahedron
  IdVector<TetId, std::array<VertId, 4>> tet2vert;
  IdVector<TetId, std::array<FaceId, 4>> tet2face;  ///< the face of the neighbour that is this face
  IdVector<TetId, std::array<FaceTag, 4>> face_tag;
  IdVector<TetId, std::int32_t> tet_ref;
  IdVector<TetId, TetClass> tet_class;
  // for the whole mesh
  std::vector<std::int32_t> patch_ref;  ///< file reference of each patch; the same on every rank
  FeatureEdges features;                ///< ridges, lines, rims, and edges with a reference

  [[nodiscard]] std::size_t vert_slots() const noexcept { return coords.size(); }
  [[nodiscard]] std::size_t tet_slots() const noexcept { return tet2vert.size(); }
  void reserve(std::size_t verts, std::size_t tets) {
    reserve_verts(verts);
    tet2vert.reserve(tets);
    tet2face.reserve(tets);
    face_tag.reserve(tets);
    tet_ref.reserve(tets);
    tet_class.reserve(tets);
  }
  /// Room in the columns that are there, and in those that always are.
  void reserve_verts(std::size_t verts) {
    coords.reserve(verts);
    vert_ref.reserve(verts);
    vert_class.reserve(verts);
    vert_state.reserve(verts);
    vert2tet.reserve(verts);
    for_each_vert_column(*this, [&](auto& c) {
      if (!c.empty()) c.raw().reserve(verts * width_of(c));
    });
  }
  /// The face behind face f, of the neighbour; kNoFace: none here.
  [[nodiscard]] FaceId neighbour(FaceId f) const noexcept { return tet2face[face_tet(f)][face_side(f)]; }
  [[nodiscard]] FaceId& neighbour(FaceId f) noexcept { return tet2face[face_tet(f)][face_side(f)]; }
  [[nodiscard]] FaceTag tag(FaceId f) const noexcept { return face_tag[face_tet(f)][face_side(f)]; }
  [[nodiscard]] FaceTag& tag(FaceId f) noexcept { return face_tag[face_tet(f)][face_side(f)]; }
  /// The vertex of the tetrahedron that is opposite face f.
  [[nodiscard]] VertId apex(FaceId f) const noexcept { return tet2vert[face_tet(f)][face_side(f)]; }
  /// The vertices of face f, counter-clockwise seen from outside the tetrahedron.
  [[nodiscard]] std::array<VertId, 3> verts(FaceId f) const noexcept {
    const auto& v = tet2vert[face_tet(f)];
    const auto& k = kFaceVerts[face_side(f)];
    return {v[k[0]], v[k[1]], v[k[2]]};
  }
  /// The ends of edge e (of kEdgeVerts) of t.
  [[nodiscard]] std::array<VertId, 2> edge_verts(TetId t, std::size_t e) const noexcept {
    return {tet2vert[t][kEdgeVerts[e][0]], tet2vert[t][kEdgeVerts[e][1]]};
  }
  /// The feature edge between two vertices; null if there is none.
  [[nodiscard]] const FeatureEdge* feature(VertId a, VertId b) const noexcept {
    return has(a, kRidge) && has(b, kRidge) ? features.find(a, b) : nullptr;
  }
  /// Makes two faces neighbours.
  void link(FaceId f, FaceId g) noexcept {
    neighbour(f) = g;
    neighbour(g) = f;
  }
  [[nodiscard]] bool is_live(TetId t) const noexcept { return tet2vert[t][0] != kNoVert; }
  [[nodiscard]] bool is_live(VertId v) const noexcept { return vert2tet[v] != kNoTet; }
  /// The vertex has one of these flags.
  [[nodiscard]] bool has(VertId v, VertClass flags) const noexcept { return any(vert_class[v] & flags); }
  [[nodiscard]] bool has(TetId t, TetClass flags) const noexcept { return any(tet_class[t] & flags); }
  [[nodiscard]] bool has(VertId v, VertState flags) const noexcept { return any(vert_state[v] & flags); }
};

/// Six times the volume of a tetrahedron (rounded).
inline double volume6(const TetMesh& m, TetId t) noexcept {
  const auto& v = m.tet2vert[t];
  return volume6(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]]);
}

}  // namespace skein
