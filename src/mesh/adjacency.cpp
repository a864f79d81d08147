// Adjacency by hashing faces on their smallest vertex; compaction along the Hilbert curve.
#include "mesh/adjacency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "base/error.hpp"
#include "base/hilbert.hpp"
#include "base/radix_sort.hpp"

namespace skein {
namespace {

struct SortedFace {
  VertId a, b, c;
  friend bool operator==(const SortedFace&, const SortedFace&) = default;
};
SortedFace sorted_face(const std::array<VertId, 4>& v, std::size_t side) noexcept {
  const auto& k = kFaceVerts[side];
  VertId a = v[k[0]], b = v[k[1]], c = v[k[2]];
  if (b < a) std::swap(a, b);
  if (c < b) std::swap(b, c);
  if (b < a) std::swap(a, b);
  return {a, b, c};
}

[[noreturn]] void throw_crowded(const TetMesh& m, const SortedFace& key) {
  std::string tets;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t f = 0; f < 4; ++f) {
      if (sorted_face(m.tet2vert[t], f) == key) tets += fmt::format(" {}", num(t) + 1);
    }
  }
  const Vec3 x = m.coords[key.a];
  throw Error(ExitCode::kInvalidMesh, fmt::format("a face at ({:.6g}, {:.6g}, {:.6g}) has more than two tetrahedra "
                                                  "(local numbers{}); remove the overlapping ones",
                                                  x.x, x.y, x.z, tets));
}

}  // namespace

void build_adjacency(TetMesh& m) {
  const std::size_t nv = m.vert_slots(), nt = m.tet_slots();
  m.tet2face.assign(nt, {kNoFace, kNoFace, kNoFace, kNoFace});
  m.vert2tet.assign(nv, kNoTet);
  // One chain of open faces per smallest vertex: head per vertex, next per face. Chains stay short (valence ~ 24/3).
  std::vector<std::int32_t> head(nv, -1), next(4 * nt, -1);
  for (const TetId t : IdRange<TetId>(nt)) {
    const auto& v = m.tet2vert[t];
    for (const VertId w : v) m.vert2tet[w] = t;
    for (std::size_t f = 0; f < 4; ++f) {
      const SortedFace key = sorted_face(v, f);
      const FaceId me = make_face(t, f);
      std::int32_t* link = &head[idx(key.a)];
      while (*link >= 0) {
        const FaceId other{*link};
        if (sorted_face(m.tet2vert[face_tet(other)], face_side(other)) == key) {
          auto& back = m.neighbour(other);
          if (back != kNoFace) throw_crowded(m, key);
          back = me;
          m.tet2face[t][f] = other;
          break;
        }
        link = &next[idx(other)];
      }
      // Matched faces stay in the chain, so that a third tetrahedron is seen.
      if (*link < 0) *link = num(me);
    }
  }
}

void mark_boundary_vertices(TetMesh& m) {
  for (VertClass& c : m.vert_class) c &= ~(kSurface | kRidge);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      if (m.face_tag[t][f] == 0) continue;
      for (const VertId v : m.verts(make_face(t, f))) m.vert_class[v] |= kSurface;
    }
  }
  for (const auto& e : m.features.list()) {
    m.vert_class[e.a] |= kRidge;
    m.vert_class[e.b] |= kRidge;
  }
}

namespace {

template <class Id, class T>
void gather(IdVector<Id, T>& v, const std::vector<Id>& from) {
  if (v.empty() && !from.empty()) return;  // an array that the caller does not keep
  IdVector<Id, T> out;
  out.reserve(std::max(v.raw().capacity(), from.size()));  // what was to come still has its place
  for (const Id i : from) out.push_back(v[i]);
  v = std::move(out);
}

template <class Column>
void gather_entries(Column& c, const std::vector<VertId>& from) {
  Column out;
  gather_column(out, c, from, c.raw().capacity() / std::max(width_of(c), std::size_t{1}));
  c = std::move(out);
}

/// Of the live vertices.
Box bounding_box(const TetMesh& m) noexcept {
  Box box = kEmptyBox;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (m.is_live(v)) box = join(box, m.coords[v]);
  }
  return box;
}

FeatureEdges renumbered(const FeatureEdges& old, const IdVector<VertId, VertId>& old2new) {
  FeatureEdges out;
  for (const auto& e : old.list()) out.insert({old2new[e.a], old2new[e.b], e.ref, e.edge_class});
  return out;
}

}  // namespace

IdVector<VertId, VertId> compact(TetMesh& m, IdVector<TetId, TetId>* tet_map) {
  const std::size_t nv = m.vert_slots(), nt = m.tet_slots();
  const Box box = bounding_box(m);
  std::vector<std::uint64_t> key(nv);
  hilbert_keys({m.coords.data(), nv}, box, key);
  std::vector<KeyIndex> order;
  order.reserve(nv);
  for (const VertId v : IdRange<VertId>(nv)) {
    if (m.is_live(v)) order.push_back({key[idx(v)], static_cast<std::uint32_t>(idx(v))});
  }
  radix_sort(order);
  std::vector<VertId> new2old(order.size());
  IdVector<VertId, VertId> old2new(nv, kNoVert);
  for (std::size_t i = 0; i < order.size(); ++i) {
    new2old[i] = to_id<VertId>(order[i].index);
    old2new[new2old[i]] = to_id<VertId>(i);
  }
  order = {};

  // Tetrahedra follow their lowest vertex: by counting sort, as that order is along the curve, too.
  std::vector<std::int32_t> first(new2old.size() + 1, 0);
  std::size_t live_tets = 0;
  const auto lowest = [&](TetId t) {
    const auto& v = m.tet2vert[t];
    return idx(std::min({old2new[v[0]], old2new[v[1]], old2new[v[2]], old2new[v[3]]}));
  };
  for (const TetId t : IdRange<TetId>(nt)) {
    if (!m.is_live(t)) continue;
    ++live_tets;
    ++first[lowest(t) + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<TetId> tet_new2old(live_tets);
  IdVector<TetId, TetId> tet_old2new(nt, kNoTet);
  for (const TetId t : IdRange<TetId>(nt)) {
    if (!m.is_live(t)) continue;
    const auto at = static_cast<std::size_t>(first[lowest(t)]++);
    tet_new2old[at] = t;
    tet_old2new[t] = to_id<TetId>(at);
  }

  for_each_vert_column(m, [&](auto& c) { gather_entries(c, new2old); });
  gather(m.vert2tet, new2old);
  for (auto& t : m.vert2tet) t = tet_old2new[t];
  gather(m.tet2vert, tet_new2old);
  gather(m.tet2face, tet_new2old);
  gather(m.face_tag, tet_new2old);
  gather(m.tet_ref, tet_new2old);
  gather(m.tet_class, tet_new2old);
  for (auto& tv : m.tet2vert) {
    for (auto& v : tv) v = old2new[v];
  }
  for (auto& tf : m.tet2face) {
    for (auto& f : tf) {
      if (f != kNoFace) f = make_face(tet_old2new[face_tet(f)], face_side(f));
    }
  }
  m.features = renumbered(m.features, old2new);
  if (tet_map != nullptr) *tet_map = std::move(tet_old2new);
  return old2new;
}

namespace {

/// The live ones' new numbers; their count.
template <class Id>
std::size_t count_up(const TetMesh& m, IdVector<Id, Id>& old2new) {
  std::size_t n = 0;
  for (const Id i : IdRange<Id>(old2new.size())) old2new[i] = m.is_live(i) ? to_id<Id>(n++) : to_id<Id>(-1);
  return n;
}

}  // namespace

IdVector<VertId, VertId> squeeze(TetMesh& m) {
  IdVector<VertId, VertId> verts(m.vert_slots());
  IdVector<TetId, TetId> tets(m.tet_slots());
  const std::size_t nv = count_up(m, verts), nt = count_up(m, tets);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (tets[t] == kNoTet) continue;
    for (auto& v : m.tet2vert[t]) v = verts[v];
    for (auto& f : m.tet2face[t]) {
      if (f != kNoFace) f = make_face(tets[face_tet(f)], face_side(f));
    }
  }
  for (auto& t : m.vert2tet) {
    if (t != kNoTet) t = tets[t];
  }
  squeeze(m.tet2vert, tets, nt);
  squeeze(m.tet2face, tets, nt);
  squeeze(m.face_tag, tets, nt);
  squeeze(m.tet_ref, tets, nt);
  squeeze(m.tet_class, tets, nt);
  for_each_vert_column(m, [&](auto& c) { squeeze_column(c, verts, nv); });
  squeeze(m.vert2tet, verts, nv);
  m.features = renumbered(m.features, verts);
  return verts;
}

}  // namespace skein
