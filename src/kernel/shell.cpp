// Walking round edges and vertices.
#include "kernel/shell.hpp"

namespace skein {

int Shell::tagged_faces() const noexcept {
  int c = 0;
  for (int i = 0; i < ring_size(); ++i) c += tag[i] != 0;
  return c;
}

namespace {

enum class Walk { kRound, kOpen, kTooFar };

/// From t0 with the ring edge (c, d) on, until the walk is back at t0, at an open face, or has met `max` tetrahedra.
Walk walk_forward(const TetMesh& m, TetId t0, VertId c, VertId d, Shell& s, int max) noexcept {
  s.closed = false;
  s.n = 0;
  s.ring[0] = c;
  TetId t = t0;
  for (;;) {
    if (s.n == max) return Walk::kTooFar;
    s.tet[s.n] = t;
    ++s.n;
    s.ring[s.n] = d;
    const auto side = local_index(m.tet2vert[t], c);  // the face a, b, d
    s.tag[s.n] = m.face_tag[t][side];
    const FaceId f = m.tet2face[t][side];
    if (f == kNoFace) {
      s.on_interface = !is_hull(s.tag[s.n]);
      return Walk::kOpen;
    }
    t = face_tet(f);
    if (t == t0) {
      s.closed = true;
      s.tag[0] = s.tag[s.n];
      return Walk::kRound;
    }
    c = d;
    d = m.tet2vert[t][face_side(f)];
  }
}
}  // namespace

bool gather_shell(const TetMesh& m, TetId t0, VertId a, VertId b, Shell& s, int max) noexcept {
  s.a = a;
  s.b = b;
  // Orient: ring goes c -> d in t0 with (a, b, c, d) positive.
  const auto& tv0 = m.tet2vert[t0];
  const std::size_t ia = local_index(tv0, a), ib = local_index(tv0, b);
  VertId c = kNoVert, d = kNoVert;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& ev = kEdgeVerts[e];
    const auto& op = kEdgeOpposite[e];
    if (ev[0] == ia && ev[1] == ib) {
      c = tv0[op[0]];
      d = tv0[op[1]];
      break;
    }
    if (ev[0] == ib && ev[1] == ia) {
      c = tv0[op[1]];
      d = tv0[op[0]];
      break;
    }
  }
  s.on_interface = false;
  switch (walk_forward(m, t0, c, d, s, max)) {
    case Walk::kRound:
      return true;
    case Walk::kTooFar:
      return false;
    case Walk::kOpen:
      break;
  }
  // An open shell: back to its first face, and from there to the last.
  TetId t = t0;
  for (int guard = 0;; ++guard) {
    if (guard > max) return false;
    const FaceId f = m.tet2face[t][local_index(m.tet2vert[t], d)];  // the face a, b, c
    if (f == kNoFace) break;
    t = face_tet(f);
    d = c;
    c = m.tet2vert[t][face_side(f)];
  }
  if (t != t0 && walk_forward(m, t, c, d, s, max) == Walk::kTooFar) return false;
  s.tag[0] = m.face_tag[t][local_index(m.tet2vert[t], d)];
  s.on_interface = s.on_interface || !is_hull(s.tag[0]);
  return true;
}

unsigned large_rings(const TetMesh& m, TetId t) noexcept {
  const auto& tv = m.tet2vert[t];
  const auto& tf = m.tet2face[t];
  std::array<VertId, 4> apex;
  for (std::size_t f = 0; f < 4; ++f) {
    apex[f] = tf[f] == kNoFace ? kNoVert : m.apex(tf[f]);
  }
  unsigned large = 0;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto c = kEdgeOpposite[e][0], d = kEdgeOpposite[e][1];
    // Behind the two faces at the edge; with one apex they close a ring of three.
    if (tf[c] == kNoFace || tf[d] == kNoFace || apex[c] == apex[d]) continue;
    // A ring of four: the tetrahedron after the next has the other neighbour's apex.
    const TetId next = face_tet(tf[c]);
    const FaceId f = m.tet2face[next][local_index(m.tet2vert[next], tv[d])];
    if (f == kNoFace || m.apex(f) == apex[d]) continue;
    large |= 1U << e;
  }
  return large;
}

void mark_refused(Part& p, const Shell& s) noexcept {
  for (int i = 0; i < s.n; ++i) {
    const TetId t = s.tet[i];
    const auto& tv = p.mesh.tet2vert[t];
    p.refused[t] |= static_cast<std::uint8_t>(1U << kEdgeOf[local_index(tv, s.a)][local_index(tv, s.b)]);
  }
}

bool gather_ball(Part& p, VertId v, std::vector<TetId>& ball, std::size_t max) {
  const std::uint32_t stamp = ++p.tet_stamp;
  const std::size_t begin = ball.size();
  p.tet_mark[p.mesh.vert2tet[v]] = stamp;
  ball.push_back(p.mesh.vert2tet[v]);
  if (!p.contacts.empty()) {
    for (const TetId t : p.contacts.at(v)) {
      if (!ContactFans::is_at(p.mesh, t, v) || p.tet_mark[t] == stamp) continue;
      p.tet_mark[t] = stamp;
      ball.push_back(t);
    }
  }
  return walk_ball(p.mesh, v, ball, begin, max, [&](FaceId f) {
    const TetId nb = face_tet(f);
    if (p.tet_mark[nb] == stamp) return true;
    p.tet_mark[nb] = stamp;
    ball.push_back(nb);
    return true;
  });
}

}  // namespace skein
