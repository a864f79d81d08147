// Judging and committing cavities.
#include "kernel/cavity.hpp"

#include <algorithm>
#include <bit>

#include "mesh/predicates.hpp"

namespace skein {

Cavity::Cavity(Part& part) : part_(&part), table_(1024), table_mask_(table_.size() - 1), mates_(kMaxLink * kMaxLink) {
  old_.reserve(256);
  fresh_.reserve(256);
  slots_.reserve(256);
  walls_.reserve(64);
}

void Cavity::clear() noexcept {
  old_.clear();
  clear_new();
  stamp_ = part_->tet_stamp += 2;
}

void Cavity::add(TetId t) {
  part_->tet_mark[t] = stamp_;
  old_.push_back(t);
}

void Cavity::remove_at(std::size_t i) noexcept {
  part_->tet_mark[old_[i]] = 0;
  old_[i] = old_.back();
  old_.pop_back();
}

void Cavity::clear_new() noexcept {
  fresh_.clear();
  walls_.clear();
  new_min_ = 1;
}

double Cavity::judge(VertId a, VertId b, VertId c, VertId d) const noexcept {
  const auto& x = part_->mesh.coords;
  if (orient3d_sign(x[a], x[b], x[c], x[d]) <= 0) return 0;
  return part_->quality_cubed(a, b, c, d);
}

bool Cavity::propose(VertId a, VertId b, VertId c, VertId d, std::int32_t ref, double floor_q3) {
  const double q3 = judge(a, b, c, d);
  if (!(q3 > floor_q3) || !(q3 > 0)) return false;
  new_min_ = std::min(new_min_, q3);
  accept(a, b, c, d, ref, q3);
  return true;
}

void Cavity::wall(VertId a, VertId b, VertId c, FaceTag tag) { walls_.push_back({a, b, c, tag}); }

double Cavity::old_min_q3() const noexcept {
  float q = 1;
  for (const TetId t : old_) q = std::min(q, part_->q3[t]);
  return q;
}

double Cavity::old_sum() const noexcept {
  double sum = 0;
  for (const TetId t : old_) sum += inverse_sixth_power(static_cast<double>(part_->q3[t]));
  return sum;
}

double Cavity::new_sum() const noexcept {
  double sum = 0;
  for (const Fresh& f : fresh_) sum += inverse_sixth_power(static_cast<double>(f.q3));
  return sum;
}

Cavity::Entry& Cavity::lookup(VertId a, VertId b, VertId c) noexcept {
  if (b < a) std::swap(a, b);
  if (c < b) std::swap(b, c);
  if (b < a) std::swap(a, b);
  std::uint64_t h = static_cast<std::uint64_t>(num(a)) * 0x9e3779b97f4a7c15ULL;
  h = (h ^ static_cast<std::uint64_t>(num(b))) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ static_cast<std::uint64_t>(num(c))) * 0x94d049bb133111ebULL;
  std::size_t s = (h >> 40) & table_mask_;
  for (;; s = (s + 1) & table_mask_) {
    Entry& e = table_[s];
    if (e.stamp != table_stamp_) {
      e = {a, b, c, 0, kNoFace, 0, false};
      return e;  // stamp 0: not there yet
    }
    if (e.a == a && e.b == b && e.c == c) return e;
  }
}

void Cavity::enter_outer_faces() {
  const TetMesh& m = part_->mesh;
  for (const TetId t : old_) {
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceId nb = m.tet2face[t][f];
      if (nb != kNoFace && contains(face_tet(nb))) continue;
      const auto v = m.verts(make_face(t, f));
      Entry& e = lookup(v[0], v[1], v[2]);
      e.stamp = table_stamp_;
      e.face = nb;
      e.tag = m.face_tag[t][f];
      e.open = false;
      // A vertex may lose all its old tetrahedra without getting a new one; then it goes on with one outside.
      if (nb != kNoFace) {
        for (const VertId w : v) {
          part_->mesh.vert2tet[w] = face_tet(nb);
          if (!part_->contacts.empty() && m.has(w, kContact)) part_->contacts.note(m, w, face_tet(nb));
        }
      }
    }
  }
  for (const Wall& w : walls_) {
    Entry& e = lookup(w.a, w.b, w.c);
    if (e.stamp == table_stamp_ && e.face != kNoFace) {
      // The wall comes to lie on an outer face: what is behind that becomes the tetrahedron at the wall.
      const TetId t = face_tet(e.face);
      const auto s = face_side(e.face);
      part_->mesh.tet2face[t][s] = kNoFace;
      part_->mesh.face_tag[t][s] = w.tag;
      part_->dirty[t] |= kAnew;
      e.face = kNoFace;
      continue;
    }
    e.stamp = table_stamp_;
    e.face = kNoFace;
    e.tag = w.tag;
    e.open = true;
  }
}

void Cavity::note_contacts() {
  Part& p = *part_;
  if (p.contacts.empty()) return;
  for (const TetId t : slots_) {
    for (const VertId v : p.mesh.tet2vert[t]) {
      if (p.mesh.has(v, kContact)) p.contacts.note(p.mesh, v, t);
    }
  }
}

TetId Cavity::take_slot(std::size_t i) {
  if (i < old_.size()) return old_[i];
  Part& p = *part_;
  if (!p.free_tets.empty()) {
    const TetId t = p.free_tets.back();
    p.free_tets.pop_back();
    return t;
  }
  p.mesh.tet2vert.push_back({kNoVert, kNoVert, kNoVert, kNoVert});
  p.mesh.tet2face.push_back({});
  p.mesh.face_tag.push_back({});
  p.mesh.tet_ref.push_back(0);
  p.mesh.tet_class.push_back({});
  p.q3.push_back(0);
  p.dirty.push_back(0);
  p.refused.push_back(0);
  p.edges.push_back({});
  return p.tet_mark.push_back(0);
}

void Cavity::link(TetId t) {
  TetMesh& m = part_->mesh;
  for (std::size_t f = 0; f < 4; ++f) {
    const FaceId me = make_face(t, f);
    const auto v = m.verts(me);
    Entry& e = lookup(v[0], v[1], v[2]);
    if (e.stamp != table_stamp_) {  // first side of an inner face
      e.stamp = table_stamp_;
      e.open = true;
      e.face = me;
      m.tet2face[t][f] = kNoFace;
      m.face_tag[t][f] = 0;
      continue;
    }
    m.face_tag[t][f] = e.tag;
    m.tet2face[t][f] = e.face;
    if (e.face != kNoFace) {
      m.neighbour(e.face) = me;
    } else if (e.open) {  // first side of a wall
      e.face = me;
    }
  }
}

void Cavity::commit() {
  Part& p = *part_;
  TetMesh& m = p.mesh;
  // The part of the table that is used grows with the cavity, so that small ones stay in few cache lines.
  const std::size_t want = std::bit_ceil(2 * (4 * fresh_.size() + 4 * old_.size() + walls_.size()));
  if (want > table_.size()) {
    table_.assign(want, Entry{});
    table_stamp_ = 0;
  }
  table_mask_ = want - 1;
  ++table_stamp_;
  enter_outer_faces();
  for (const TetId t : old_) p.tet_mark[t] = 0;
  slots_.clear();
  for (std::size_t i = 0; i < fresh_.size(); ++i) {
    const TetId t = take_slot(i);
    slots_.push_back(t);
    m.tet2vert[t] = fresh_[i].v;
    m.tet_ref[t] = fresh_[i].ref;
    p.q3[t] = fresh_[i].q3;
    p.refused[t] = 0;
    p.dirty[t] = kAnew;
    p.edges[t] = p.classify_edges(t);
    for (const VertId v : fresh_[i].v) m.vert2tet[v] = t;
  }
  for (const TetId t : slots_) link(t);
  free_rest(fresh_.size());
  note_contacts();
}

void Cavity::commit_cone(VertId apex, std::span<const BorderFace> border, const Cone& cone,
                         std::span<const VertId> link) {
  // Two new tetrahedra share the face over an edge of the border, which one meets as (a, b), the other as (b, a): a
  // table over the link's vertices, numbered from 0, is all it takes to find each other.
  Part& p = *part_;
  TetMesh& m = p.mesh;
  for (std::size_t i = 0; i < link.size(); ++i) p.vert_mark[link[i]] = static_cast<std::uint32_t>(i);
  const auto mate = [&](VertId a, VertId b) -> FaceId& { return mates_[p.vert_mark[a] * kMaxLink + p.vert_mark[b]]; };
  slots_.clear();
  for (std::size_t i = 0; i < border.size(); ++i) {
    const BorderFace& f = border[i];
    const TetId t = take_slot(i);
    slots_.push_back(t);
    EdgeBits edges = f.edges;
    for (std::size_t e = 0; e < 3; ++e) {
      edges.add(e, p.edge_class[f.v[e]]);
      m.vert2tet[f.v[e]] = t;
    }
    p.edges[t] = edges;
    m.tet2vert[t] = {apex, f.v[0], f.v[1], f.v[2]};
    m.tet2face[t][0] = f.behind;
    m.face_tag[t] = {f.tag, 0, 0, 0};
    m.tet_ref[t] = f.ref;
    p.q3[t] = static_cast<float>(cone.q3(i));
    p.dirty[t] = kAnew;
    p.tet_mark[t] = 0;
    p.refused[t] = 0;
    if (f.behind != kNoFace) {
      m.neighbour(f.behind) = make_face(t, 0);
    }
    mate(f.v[0], f.v[1]) = make_face(t, 3);
    mate(f.v[1], f.v[2]) = make_face(t, 1);
    mate(f.v[2], f.v[0]) = make_face(t, 2);
  }
  m.vert2tet[apex] = slots_.front();
  for (std::size_t i = 0; i < border.size(); ++i) {
    const auto& v = border[i].v;
    auto& faces = m.tet2face[slots_[i]];
    faces[3] = mate(v[1], v[0]);
    faces[1] = mate(v[2], v[1]);
    faces[2] = mate(v[0], v[2]);
  }
  for (const VertId v : link) p.vert_mark[v] = 0;
  free_rest(border.size());
  note_contacts();
}

void Cavity::link_behind(TetId t, std::size_t side, FaceId behind, FaceTag tag) noexcept {
  TetMesh& m = part_->mesh;
  m.tet2face[t][side] = behind;
  m.face_tag[t][side] = tag;
  if (behind != kNoFace) {
    m.neighbour(behind) = make_face(t, side);
  }
}

namespace {
constexpr std::size_t u(int i) noexcept { return static_cast<std::size_t>(i); }

/// What one tetrahedron of a shell leaves: the faces opposite a and b (of the side of b and of a), and the classes of
/// the edges between its ring vertices and from the first of them to b and a.
struct Rim {
  std::array<FaceId, 2> behind;
  std::array<FaceTag, 2> tag;
  std::uint8_t along;
  std::array<std::uint8_t, 2> spoke;
};

Rim rim_of(const Part& p, const Shell& s, int i) noexcept {
  const TetId t = s.tet[i];
  const auto& tv = p.mesh.tet2vert[t];
  const int a = local_index(tv, s.a), b = local_index(tv, s.b), c = local_index(tv, s.ring[i]), d = 6 - a - b - c;
  const auto& face = p.mesh.tet2face[t];
  const auto& tag = p.mesh.face_tag[t];
  const EdgeBits e = p.edges[t];
  return {{face[a], face[b]}, {tag[a], tag[b]}, e.of(kEdgeOf[c][d]), {e.of(kEdgeOf[b][c]), e.of(kEdgeOf[a][c])}};
}

/// All that is kept of a new tetrahedron besides its vertices and neighbours.
void set_fresh(Part& p, TetId t, std::int32_t ref, double q3, EdgeBits edges) noexcept {
  p.edges[t] = edges;
  p.q3[t] = static_cast<float>(q3);
  p.dirty[t] = kAnew;
  p.refused[t] = 0;
  p.tet_mark[t] = 0;
  p.mesh.tet_ref[t] = ref;
}
}  // namespace

void Cavity::commit_ring(const Shell& s, std::span<const RingTriangle> triangles) {
  Part& p = *part_;
  TetMesh& m = p.mesh;
  std::array<Rim, kMaxRing> rim;
  for (int i = 0; i < s.n; ++i) rim[i] = rim_of(p, s, i);
  const std::int32_t ref = m.tet_ref[s.tet[0]];
  slots_.clear();
  for (std::size_t i = 0; i < 2 * triangles.size(); ++i) slots_.push_back(take_slot(i));

  /// Of an edge (x, y) inside the polygon, met first from the triangle that it is a short side of.
  struct Diagonal {
    std::array<FaceId, 2> face;
    std::uint8_t edge_class;
  };
  std::array<std::array<Diagonal, kMaxRing>, kMaxRing> diagonal;
  // Joins the two new tetrahedra over (x, y) to what is beyond; `side`: of theirs. Returns the class of the edge.
  const auto join = [&](const std::array<TetId, 2>& t, int x, int y, const std::array<int, 2>& side, bool is_long) {
    const bool closes = y - x == s.n - 1;
    if (y - x == 1 || closes) {
      const Rim& r = rim[closes ? y : x];
      for (std::size_t k = 0; k < 2; ++k) link_behind(t[k], u(side[k]), r.behind[k], r.tag[k]);
      return r.along;
    }
    Diagonal& d = diagonal[x][y];
    if (is_long) {
      for (std::size_t k = 0; k < 2; ++k) link_behind(t[k], u(side[k]), d.face[k], 0);
    } else {
      d.edge_class = p.classify(s.ring[x], s.ring[y]);
      for (std::size_t k = 0; k < 2; ++k) {
        d.face[k] = make_face(t[k], side[k]);
        m.face_tag[t[k]][side[k]] = 0;
      }
    }
    return d.edge_class;
  };
  for (std::size_t q = 0; q < triangles.size(); ++q) {
    const auto& [i, k, j, with_b, with_a] = triangles[q];
    const VertId vi = s.ring[i], vk = s.ring[k], vj = s.ring[j];
    const std::array<TetId, 2> t{slots_[2 * q], slots_[2 * q + 1]};
    m.tet2vert[t[0]] = {vi, vk, vj, s.b};
    m.tet2vert[t[1]] = {vi, vj, vk, s.a};
    const std::uint8_t kj = join(t, k, j, {0, 0}, false), ij = join(t, i, j, {1, 2}, true),
                       ik = join(t, i, k, {2, 1}, false);
    link_behind(t[0], 3, make_face(t[1], 3), 0);
    m.face_tag[t[1]][3] = 0;
    const std::array<std::array<std::uint8_t, 6>, 2> classes{
        {{ik, ij, rim[i].spoke[0], kj, rim[k].spoke[0], rim[j].spoke[0]},
         {ij, ik, rim[i].spoke[1], kj, rim[j].spoke[1], rim[k].spoke[1]}}};
    for (std::size_t side = 0; side < 2; ++side) {
      EdgeBits edges;
      for (std::size_t e = 0; e < 6; ++e) edges.add(e, classes[side][e]);
      set_fresh(p, t[side], ref, side == 0 ? with_b : with_a, edges);
    }
    m.vert2tet[vi] = m.vert2tet[vk] = m.vert2tet[vj] = m.vert2tet[s.b] = t[0];
    m.vert2tet[s.a] = t[1];
  }
  free_rest(2 * triangles.size());
  note_contacts();
}

void Cavity::free_rest(std::size_t used) {
  for (std::size_t i = used; i < old_.size(); ++i) {
    part_->mesh.tet2vert[old_[i]] = {kNoVert, kNoVert, kNoVert, kNoVert};
    part_->free_tets.push_back(old_[i]);
  }
}

}  // namespace skein
