// Walking round edges and vertices.
#include "kernel/shell.hpp"

namespace skein {

int Shell::tagged_faces() const noexcept {
  int c = 0;
  for (int i = 0; i < ring_size(); ++i) c += tag[static_cast<std::size_t>(i)] != 0;
  return c;
}

namespace {
constexpr std::size_t u(int i) noexcept { return static_cast<std::size_t>(i); }

/// The ring vertex other than `from` of a tetrahedron with edge a, b.
VertId other_ring_vertex(const std::array<VertId, 4>& tv, VertId a, VertId b, VertId from) noexcept {
  for (const VertId v : tv) {
    if (v != a && v != b && v != from) return v;
  }
  return kNoVert;
}
}  // namespace

bool gather_shell(const TetMesh& m, TetId t0, VertId a, VertId b, Shell& s, int max) noexcept {
  s.a = a;
  s.b = b;
  // Orient: ring goes c -> d in t0 with (a, b, c, d) positive.
  const auto& tv0 = m.tet2vert[t0];
  const int ia = local_index(tv0, a), ib = local_index(tv0, b);
  VertId c = kNoVert, d = kNoVert;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& ev = kEdgeVerts[e];
    const auto& op = kEdgeOpposite[e];
    if (ev[0] == ia && ev[1] == ib) {
      c = tv0[u(op[0])];
      d = tv0[u(op[1])];
      break;
    }
    if (ev[0] == ib && ev[1] == ia) {
      c = tv0[u(op[1])];
      d = tv0[u(op[0])];
      break;
    }
  }
  // Backward to the open end, if there is one.
  TetId t = t0;
  s.closed = false;
  for (int guard = 0; guard <= max; ++guard) {
    const FaceId f = m.tet2face[t][u(local_index(m.tet2vert[t], d))];  // the face a, b, c
    if (f == kNoFace) break;
    const TetId nb = face_tet(f);
    if (nb == t0) {
      s.closed = true;
      break;
    }
    const VertId before = m.tet2vert[nb][u(face_side(f))];
    d = c;
    c = before;
    t = nb;
    if (guard == max) return false;
  }
  // Forward.
  s.n = 0;
  const TetId first = t;
  s.ring[0] = c;
  s.tag[0] = m.face_tag[t][u(local_index(m.tet2vert[t], d))];
  s.on_interface = !s.closed && !is_hull(s.tag[0]);
  for (;;) {
    if (s.n == max) return false;
    s.tet[u(s.n)] = t;
    const VertId next = other_ring_vertex(m.tet2vert[t], a, b, c);
    ++s.n;
    s.ring[u(s.n)] = next;
    const auto side = u(local_index(m.tet2vert[t], c));
    s.tag[u(s.n)] = m.face_tag[t][side];
    const FaceId f = m.tet2face[t][side];
    if (f == kNoFace) {
      s.on_interface = s.on_interface || !is_hull(s.tag[u(s.n)]);
      break;
    }
    t = face_tet(f);
    if (t == first) break;
    c = next;
  }
  return true;
}

bool gather_ball(Part& p, VertId v, std::vector<TetId>& ball, std::size_t max) {
  const TetMesh& m = p.mesh;
  const std::uint32_t stamp = ++p.tet_stamp;
  const std::size_t begin = ball.size();
  const TetId t0 = m.vert2tet[v];
  p.tet_mark[t0] = stamp;
  ball.push_back(t0);
  for (std::size_t i = begin; i < ball.size(); ++i) {
    const TetId t = ball[i];
    const auto& tv = m.tet2vert[t];
    const auto& tf = m.tet2face[t];
    for (std::size_t f = 0; f < 4; ++f) {
      if (tv[f] == v || tf[f] == kNoFace) continue;
      const TetId nb = face_tet(tf[f]);
      if (p.tet_mark[nb] == stamp) continue;
      p.tet_mark[nb] = stamp;
      ball.push_back(nb);
    }
    if (ball.size() - begin > max) return false;
  }
  return true;
}

}  // namespace skein
