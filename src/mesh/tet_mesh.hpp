// TetMesh: one rank's (or one part's) tetrahedra as a struct of arrays.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/ids.hpp"
#include "base/vec3.hpp"
#include "mesh/feature_edges.hpp"

namespace skein {

/// What a vertex is; a set of bits.
enum VertFlag : std::uint8_t {
  kSurface = 1,        ///< lies on a tagged face (domain boundary or internal interface)
  kRidge = 2,          ///< lies on a feature edge
  kCorner = 4,         ///< never moves, never goes (end or junction of feature edges, or given as corner)
  kRequired = 8,       ///< given as required: never moves, never goes
  kFrozen = 16,        ///< on the interface to another part: not to be touched in this round
  kActive = 32,        ///< still to be looked at
  kBesideFrozen = 64,  ///< of a tetrahedron that could be better and has a vertex that had to stay in the last round
  kRetry = 128,        ///< what is round it is to be looked at first: a frozen vertex was in the way of the last round
};

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

/// Tetrahedra with adjacency. A tetrahedron is oriented so that det(v1-v0, v2-v0, v3-v0) > 0.
/// A free slot has tet2vert[t][0] == kNoVert; a free vertex has vert2tet == kNoTet.
/// A face with tet2face == kNoFace is on the hull (tag has kHullFace) or on the interface to another part.
struct TetMesh {
  // per vertex
  IdVector<VertId, Vec3> coords;              ///< length unit of the input
  IdVector<VertId, std::int32_t> vert_ref;    ///< reference of the file
  IdVector<VertId, std::uint8_t> vert_flags;  ///< VertFlag bits
  IdVector<VertId, TetId> vert2tet;           ///< one tetrahedron at the vertex
  // per tetrahedron
  IdVector<TetId, std::array<VertId, 4>> tet2vert;
  IdVector<TetId, std::array<FaceId, 4>> tet2face;  ///< the face of the neighbour that is this face
  IdVector<TetId, std::array<FaceTag, 4>> face_tag;
  IdVector<TetId, std::int32_t> tet_ref;
  // for the whole mesh
  std::vector<std::int32_t> patch_ref;  ///< file reference of each patch; the same on every rank
  FeatureEdges features;                ///< ridges and referenced edges

  [[nodiscard]] std::size_t vert_slots() const noexcept { return coords.size(); }
  [[nodiscard]] std::size_t tet_slots() const noexcept { return tet2vert.size(); }
  void reserve(std::size_t verts, std::size_t tets) {
    coords.reserve(verts);
    vert_ref.reserve(verts);
    vert_flags.reserve(verts);
    vert2tet.reserve(verts);
    tet2vert.reserve(tets);
    tet2face.reserve(tets);
    face_tag.reserve(tets);
    tet_ref.reserve(tets);
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
  [[nodiscard]] bool has(VertId v, std::uint8_t flags) const noexcept { return (vert_flags[v] & flags) != 0; }
};

/// Six times the volume of a tetrahedron (rounded).
inline double volume6(const TetMesh& m, TetId t) noexcept {
  const auto& v = m.tet2vert[t];
  return volume6(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]]);
}

}  // namespace skein
