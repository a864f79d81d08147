// Layers of tetrahedra and vertices round given vertices.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "mesh/tet_mesh.hpp"

namespace skein {

/// Calls visit(t) for the tetrahedra with a face without a neighbour, ascending; free places may be among them. They
/// are few, so many tetrahedra at a time are asked whether any is one.
template <class Visit>
void visit_open_tets(const TetMesh& m, Visit&& visit) {
  constexpr std::size_t kAtOnce = 32;
  const std::size_t n = m.tet_slots();
  for (std::size_t i = 0; i < n; i += kAtOnce) {
    const std::size_t end = std::min(n, i + kAtOnce);
    std::int32_t any = 0;  // negative: one of them is kNoFace
    for (std::size_t j = i; j < end; ++j) {
      const auto& f = m.tet2face.raw()[j];
      any |= num(f[0]) | num(f[1]) | num(f[2]) | num(f[3]);
    }
    if (any >= 0) continue;
    for (const TetId t : IdRange<TetId>(i, end)) {
      const auto& f = m.tet2face[t];
      if ((num(f[0]) | num(f[1]) | num(f[2]) | num(f[3])) < 0) visit(t);
    }
  }
}

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
  /// Adds all tetrahedra at the vertices, whether they hang together or not.
  void add_all_tets() {
    enter_open();
    add_tets();
  }
  /// Adds vertices and all tetrahedra at them, whether these hang together or not.
  void add(const std::vector<VertId>& verts) {
    for (const VertId v : verts) {
      if (seen_[v] != 0) continue;
      seen_[v] = 1;
      verts_.push_back(v);
      enter(m_.vert2tet[v]);
    }
    enter_open();
    next_tet_ = std::min(next_tet_, newest_tet_);  // those before have no vertex that was not seen
    add_tets();
  }

  /// All tetrahedra at the vertices so far. The tetrahedra at a vertex hang together over faces, unless bodies touch
  /// there; where they do not on the interface between ranks, the vertex is frozen and it does no harm to miss some.
  void add_tets() {
    const std::size_t fresh = verts_.size() - searched_;
    const bool contact = std::any_of(verts_.begin() + static_cast<std::ptrdiff_t>(searched_), verts_.end(),
                                     [&](VertId v) { return m_.has(v, kContact); });
    searched_ = verts_.size();
    if (contact) enter_open();
    if (kScanFrom * fresh > m_.tet_slots()) {
      look_at_all();
      return;
    }
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
    add_vertices([](TetId) { return true; });
  }
  /// All vertices of those among the latest tetrahedra that are wanted(t).
  template <class Wanted>
  void add_vertices(Wanted&& wanted) {
    const std::size_t begin = newest_tet_;
    for (newest_tet_ = tets_.size(), next_tet_ = begin; next_tet_ < newest_tet_; ++next_tet_) {
      if (!wanted(tets_[next_tet_])) continue;
      for (const VertId v : m_.tet2vert[tets_[next_tet_]]) {
        if (seen_[v] != 0) continue;
        seen_[v] = 1;
        verts_.push_back(v);
      }
    }
    next_tet_ = begin;  // these have the new vertices
  }
  /// The tetrahedra with a face without a neighbour, ascending, if add() has looked for them.
  [[nodiscard]] const std::optional<std::vector<TetId>>& all_open() const noexcept { return all_open_; }
  /// The tetrahedra so far, as they were found.
  [[nodiscard]] const std::vector<TetId>& found() const noexcept { return tets_; }
  [[nodiscard]] const std::vector<VertId>& verts() const noexcept { return verts_; }
  [[nodiscard]] bool has(VertId v) const noexcept { return seen_[v] != 0; }
  [[nodiscard]] bool has(TetId t) const noexcept { return inside_[t] != 0; }
  /// The tetrahedra so far, ascending.
  [[nodiscard]] std::vector<TetId> tets() const {
    std::vector<TetId> out;
    out.reserve(tets_.size());
    constexpr std::size_t kAtOnce = sizeof(std::uint64_t);  // most of them are not inside
    const std::size_t n = inside_.size();
    for (std::size_t i = 0; i < n; i += kAtOnce) {
      if (i + kAtOnce <= n) {
        std::uint64_t any = 0;
        std::memcpy(&any, inside_.data() + i, sizeof any);
        if (any == 0) continue;
      }
      for (const TetId t : IdRange<TetId>(i, std::min(n, i + kAtOnce))) {
        if (inside_[t] != 0) out.push_back(t);
      }
    }
    return out;
  }

 private:
  /// Tetrahedra that hang together at a vertex but not with its first one have a face without a neighbour. All faces
  /// are looked at once, which is quick.
  void enter_open() {
    if (!all_open_) {
      visit_open_tets(m_, [&](TetId t) { open_.push_back(t); });
      all_open_ = open_;
    }
    std::erase_if(open_, [&](TetId t) {
      const auto& v = m_.tet2vert[t];
      if (v[0] != kNoVert && (seen_[v[0]] | seen_[v[1]] | seen_[v[2]] | seen_[v[3]]) != 0) enter(t);
      return inside_[t] != 0;
    });
  }
  void look_at_all() {
    for (const TetId t : IdRange<TetId>(m_.tet_slots())) {
      const auto& v = m_.tet2vert[t];
      if (v[0] != kNoVert && (seen_[v[0]] | seen_[v[1]] | seen_[v[2]] | seen_[v[3]]) != 0) enter(t);
    }
    next_tet_ = tets_.size();
  }
  void enter(TetId t) {
    if (inside_[t] != 0) return;
    inside_[t] = 1;
    tets_.push_back(t);
  }

  /// From one new vertex for so many tetrahedra on, a look at all of these is quicker than at neighbours of those
  /// found.
  static constexpr std::size_t kScanFrom = 200;

  const TetMesh& m_;
  IdVector<VertId, char> seen_;
  IdVector<TetId, char> inside_;
  std::vector<VertId> verts_;
  std::vector<TetId> tets_, open_;  ///< of the open ones, those that are not inside yet
  std::optional<std::vector<TetId>> all_open_;
  std::size_t searched_ = 0;                   ///< vertices whose tetrahedra have been added
  std::size_t next_tet_ = 0, newest_tet_ = 0;  ///< to look round; to take the vertices of
};

}  // namespace skein
