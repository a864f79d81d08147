// Moving what lies at the end of the arrays into their gaps.
#include "mesh/holes.hpp"

#include <algorithm>
#include <array>

namespace skein {
namespace {

template <class Vector>
void resize(Vector& v, std::size_t n) {
  reserve_with_slack(v, n);
  v.resize(n);
}

void move_tet(TetMesh& m, TetId from, TetId to) {
  m.tet2vert[to] = m.tet2vert[from];
  m.tet2face[to] = m.tet2face[from];
  m.face_tag[to] = m.face_tag[from];
  m.tet_ref[to] = m.tet_ref[from];
  for (const VertId v : m.tet2vert[to]) m.vert2tet[v] = to;
  for (std::size_t k = 0; k < 4; ++k) {
    const FaceId f = m.tet2face[to][k];
    if (f != kNoFace) link_faces(m, f, make_face(to, static_cast<int>(k)));
  }
}

}  // namespace

void link_equal_faces(TetMesh& m, std::span<const FaceId> faces) {
  struct Side {
    std::array<VertId, 3> v;
    FaceId face;
  };
  std::vector<Side> sides(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    sides[i] = {face_verts(m, faces[i]), faces[i]};
    std::sort(sides[i].v.begin(), sides[i].v.end());
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.v != b.v ? a.v < b.v : a.face < b.face; });
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].v != sides[i + 1].v) continue;
    link_faces(m, sides[i].face, sides[i + 1].face);
    ++i;
  }
}

void resize_tets(TetMesh& m, std::size_t n) {
  resize(m.tet2vert, n);
  resize(m.tet2face, n);
  resize(m.face_tag, n);
  resize(m.tet_ref, n);
}

void resize_verts(TetMesh& m, std::size_t n) {
  resize(m.coords, n);
  resize(m.vert_ref, n);
  resize(m.vert_flags, n);
  reserve_with_slack(m.vert2tet, n);
  m.vert2tet.resize(n, kNoTet);
}

void fill_free_tets(TetMesh& m, const std::vector<TetId>& free) {
  resize_tets(m, fill_holes(free, m.tet_slots(), [&](TetId from, TetId to) { move_tet(m, from, to); }));
}

void follow(TetMesh& m, const MovedVerts& now) {
  for (auto& tv : m.tet2vert) {
    for (auto& v : tv) {
      if (now.moves(v)) v = now(v);
    }
  }
  const std::vector<FeatureEdge> edges = m.features.list();
  for (const FeatureEdge& e : edges) {
    if (!now.moves(e.a) && !now.moves(e.b)) continue;
    m.features.erase(e.a, e.b);
    m.features.insert(now(e.a), now(e.b), e.ref, e.ridge);
  }
}

}  // namespace skein
