// Layers of tetrahedra and vertices round given vertices.
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// What lies round some vertices, found from them over faces.
class Surroundings {
 public:
  /// Begins with one tetrahedron at each of these vertices.
  Surroundings(const TetMesh& m, std::vector<VertId> verts)
      : m_(m), seen_(m.vert_slots(), 0), inside_(m.tet_slots(), 0), verts_(std::move(verts)) {
    for (const VertId v : verts_) {
      seen_[v] = 1;
      enter(m.vert2tet[v]);
    }
  }
  /// Adds all tetrahedra at the vertices, whether they hang together or not. Those that hang together at a vertex but
  /// not with its first tetrahedron have a face without a neighbour; so this looks at all faces, which is quick.
  void add_all_tets() {
    for (const TetId t : IdRange<TetId>(m_.tet_slots())) {
      const auto& f = m_.tet2face[t];
      if (f[0] != kNoFace && f[1] != kNoFace && f[2] != kNoFace && f[3] != kNoFace) continue;
      const auto& v = m_.tet2vert[t];
      if (v[0] != kNoVert && (seen_[v[0]] | seen_[v[1]] | seen_[v[2]] | seen_[v[3]]) != 0) enter(t);
    }
    add_tets();
  }

  /// All tetrahedra at the vertices so far. The tetrahedra at a vertex hang together over faces; where they do not, on
  /// the interface between ranks, the vertex is frozen and it does no harm to miss some.
  void add_tets() {
    for (; next_tet_ < tets_.size(); ++next_tet_) {
      for (const FaceId f : m_.tet2face[tets_[next_tet_]]) {
        if (f == kNoFace || inside_[face_tet(f)] != 0) continue;
        const auto& v = m_.tet2vert[face_tet(f)];
        if ((seen_[v[0]] | seen_[v[1]] | seen_[v[2]] | seen_[v[3]]) != 0) enter(face_tet(f));
      }
    }
  }
  /// All vertices of the tetrahedra so far.
  void add_vertices() {
    const std::size_t begin = newest_tet_;
    for (newest_tet_ = tets_.size(), next_tet_ = begin; next_tet_ < newest_tet_; ++next_tet_) {
      for (const VertId v : m_.tet2vert[tets_[next_tet_]]) {
        if (seen_[v] != 0) continue;
        seen_[v] = 1;
        verts_.push_back(v);
      }
    }
    next_tet_ = begin;  // these have the new vertices
  }
  [[nodiscard]] const std::vector<VertId>& verts() const noexcept { return verts_; }
  [[nodiscard]] bool has(VertId v) const noexcept { return seen_[v] != 0; }
  [[nodiscard]] bool has(TetId t) const noexcept { return inside_[t] != 0; }
  /// The tetrahedra so far, ascending.
  [[nodiscard]] std::vector<TetId> tets() const {
    std::vector<TetId> out;
    out.reserve(tets_.size());
    for (const TetId t : IdRange<TetId>(inside_.size())) {
      if (inside_[t] != 0) out.push_back(t);
    }
    return out;
  }

 private:
  void enter(TetId t) {
    if (inside_[t] != 0) return;
    inside_[t] = 1;
    tets_.push_back(t);
  }

  const TetMesh& m_;
  IdVector<VertId, char> seen_;
  IdVector<TetId, char> inside_;
  std::vector<VertId> verts_;
  std::vector<TetId> tets_;
  std::size_t next_tet_ = 0, newest_tet_ = 0;  ///< to look round; to take the vertices of
};

}  // namespace skein
