// Consistency of a TetMesh.
#include "mesh/check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mesh/predicates.hpp"

namespace skein {
namespace {

std::string check_faces(const TetMesh& m, TetId t) {
  for (std::size_t f = 0; f < 4; ++f) {
    const FaceId other = m.tet2face[t][f];
    const FaceTag tag = m.face_tag[t][f];
    if (tag != 0 && static_cast<std::size_t>(tag_patch(tag)) >= m.patch_ref.size()) {
      return fmt::format("face {} of tetrahedron {} has patch {} of {}", f, num(t), tag_patch(tag), m.patch_ref.size());
    }
    auto mine = m.verts(make_face(t, f));
    for (const VertId v : mine) {
      if (tag != 0 && !m.has(v, kSurface)) return fmt::format("vertex {} on a tagged face lacks kSurface", num(v));
    }
    if (other == kNoFace) continue;
    if (!m.is_live(face_tet(other))) return fmt::format("tetrahedron {} has a dead neighbour over face {}", num(t), f);
    if (m.neighbour(other) != make_face(t, f)) {
      return fmt::format("adjacency of tetrahedron {} over face {} is not symmetric", num(t), f);
    }
    if (m.tag(other) != tag) {
      return fmt::format("the two sides of face {} of tetrahedron {} have different tags", f, num(t));
    }
    if (is_hull(tag)) return fmt::format("hull face {} of tetrahedron {} has a neighbour", f, num(t));
    auto theirs = m.verts(other);
    std::swap(theirs[1], theirs[2]);  // seen from the other side
    const auto at = std::find(theirs.begin(), theirs.end(), mine[0]);
    std::rotate(theirs.begin(), at, theirs.end());
    if (at == theirs.end() || mine != theirs) {
      return fmt::format("face {} of tetrahedron {} and its neighbour'f face do not have the same vertices", f, num(t));
    }
  }
  return {};
}

}  // namespace

std::string check_sizes(const TetMesh& m) {
  const std::size_t nv = m.vert_slots(), nt = m.tet_slots();
  if (m.vert2tet.size() != nv) return fmt::format("vert2tet has {} entries for {} vertices", m.vert2tet.size(), nv);
  if (m.tet2face.size() != nt || m.face_tag.size() != nt || m.tet_ref.size() != nt || m.tet_class.size() != nt) {
    return fmt::format("the arrays of the {} tetrahedra have {}, {}, {} and {} entries", nt, m.tet2face.size(),
                       m.face_tag.size(), m.tet_ref.size(), m.tet_class.size());
  }
  std::string fault;
  int column = 0;
  for_each_vert_column(m, [&](const auto& c) {
    if (fault.empty() && !c.empty() && c.size() != nv)
      fault = fmt::format("column {} has {} entries for {} vertices", column, c.size(), nv);
    ++column;
  });
  return fault;
}

std::string check(const TetMesh& m) {
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    const auto& v = m.tet2vert[t];
    for (const VertId w : v) {
      if (w == kNoVert || idx(w) >= m.vert_slots() || !m.is_live(w)) {
        return fmt::format("tetrahedron {} has a vertex {} that is not there", num(t), num(w));
      }
    }
    if (orient3d_sign(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]]) <= 0) {
      return fmt::format("tetrahedron {} is not positive", num(t));
    }
    if (auto fault = check_faces(m, t); !fault.empty()) return fault;
  }
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (!m.is_live(v)) continue;
    const TetId t = m.vert2tet[v];
    if (!m.is_live(t)) return fmt::format("vertex {} points to a dead tetrahedron", num(v));
    const auto& tv = m.tet2vert[t];
    if (std::find(tv.begin(), tv.end(), v) == tv.end()) {
      return fmt::format("vertex {} points to tetrahedron {} that does not have it", num(v), num(t));
    }
  }
  for (const auto& e : m.features.list()) {
    for (const VertId v : {e.a, e.b}) {
      if (!m.is_live(v) || !m.has(v, kRidge)) {
        return fmt::format("feature edge {}-{} has an end that is dead or not a ridge vertex", num(e.a), num(e.b));
      }
    }
  }
  return {};
}

double volume(const TetMesh& m) noexcept {
  double sum = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (m.is_live(t)) sum += volume6(m, t) / 6;
  }
  return sum;
}

std::size_t count_tets(const TetMesh& m) noexcept {
  return static_cast<std::size_t>(
      std::count_if(m.tet2vert.begin(), m.tet2vert.end(), [](const auto& v) { return v[0] != kNoVert; }));
}

double patch_area(const TetMesh& m, int patch) noexcept {
  double sum = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f];
      if (tag == 0 || tag_patch(tag) != patch) continue;
      const auto v = m.verts(make_face(t, f));
      sum += norm(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]])) / 2;
    }
  }
  return sum;
}

}  // namespace skein
