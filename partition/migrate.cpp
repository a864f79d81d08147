// Migration in three steps: pack what leaves, close the gaps, join what comes.
#include "partition/migrate.hpp"

#include <algorithm>

#include "mesh/error.hpp"
#include "partition/feature_scan.hpp"
#include "partition/rendezvous.hpp"
#include "partition/sharing.hpp"

namespace skein {
namespace {

/// Marks in MovedTet::face instead of a neighbour.
constexpr std::int32_t kOpen = -1;          ///< its neighbour goes elsewhere, or it is a hull face
constexpr std::int32_t kWasInterface = -2;  ///< was between two ranks: its neighbour may be where it goes

// What travels; vertices and faces are numbered inside the block from one rank to another.
struct MovedTet {
  std::array<std::int32_t, 4> vert;
  std::array<std::int32_t, 4> face;
  std::array<FaceTag, 4> tag;
  std::int32_t ref;
};
struct MovedVert {
  GlobalId gid;
  Vec3 x;
  std::int32_t ref;
  std::uint8_t flags;
  std::uint8_t shared;
  std::uint16_t unused;
};
struct MovedFeature {
  std::int32_t a, b, ref, ridge;
};
struct Load {
  Packets<MovedTet> tets;
  Packets<MovedVert> verts;
  Packets<double> data;
  Packets<MovedFeature> features;
};

template <class T>
void close_block(Packets<T>& p, Rank r) {
  if (p.items.size() == p.offset.back()) return;
  p.rank.push_back(r);
  p.offset.push_back(p.items.size());
}

/// The tetrahedra that leave, by destination, in their order.
struct Leaving {
  std::vector<TetId> tets;
  std::vector<std::size_t> offset;      ///< by rank
  IdVector<TetId, std::int32_t> place;  ///< the new number if it stays, or ~ its place in its destination's block
  std::size_t stay = 0;
};

Leaving sort_out(const Comm& comm, const IdVector<TetId, Rank>& dest) {
  const Rank me = comm.rank();
  Leaving l;
  l.offset.assign(static_cast<std::size_t>(comm.size()) + 1, 0);
  for (const Rank r : dest) ++l.offset[idx(r) + 1];
  l.stay = l.offset[idx(me) + 1];
  l.offset[idx(me) + 1] = 0;
  for (std::size_t r = 1; r < l.offset.size(); ++r) l.offset[r] += l.offset[r - 1];
  l.tets.resize(l.offset.back());
  l.place.resize(dest.size());
  std::vector<std::size_t> next(l.offset.begin(), l.offset.end() - 1);
  std::int32_t stay = 0;
  for (const TetId t : IdRange<TetId>(dest.size())) {
    const std::size_t r = idx(dest[t]);
    if (dest[t] == me) {
      l.place[t] = stay++;
    } else {
      l.place[t] = ~static_cast<std::int32_t>(next[r] - l.offset[r]);
      l.tets[next[r]++] = t;
    }
  }
  return l;
}

/// The feature edges (as places in the list) that are edges of tetrahedra going to each rank; sorted, each once.
using FeatureUse = std::pair<Rank, std::uint32_t>;
std::vector<FeatureUse> features_by_rank(const TetMesh& m, const IdVector<TetId, Rank>& dest) {
  std::vector<FeatureUse> use;
  for_each_feature(m, [&](TetId t, std::uint32_t edge) { use.emplace_back(dest[t], edge); });
  std::sort(use.begin(), use.end());
  use.erase(std::unique(use.begin(), use.end()), use.end());
  return use;
}

class Packer {
 public:
  Packer(const Comm& comm, const DistMesh& dist, const IdVector<TetId, Rank>& dest, const Leaving& leaving,
         const std::vector<FeatureUse>& features)
      : comm_(comm), dist_(dist), dest_(dest), leaving_(leaving), features_(features) {
    shared_.assign(dist.mesh.vert_slots(), 0);
    for (const VertId v : dist.sharing.vert) shared_[v] = 1;
    number_.assign(dist.mesh.vert_slots(), -1);
  }
  Load pack() {
    for (std::size_t r = 0; r < static_cast<std::size_t>(comm_.size()); ++r) {
      if (leaving_.offset[r + 1] > leaving_.offset[r]) pack_block(to_id<Rank>(r));
    }
    return std::move(load_);
  }

 private:
  void pack_block(Rank r) {
    const TetMesh& m = dist_.mesh;
    used_.clear();
    for (std::size_t i = leaving_.offset[idx(r)]; i < leaving_.offset[idx(r) + 1]; ++i) pack_tet(leaving_.tets[i], r);
    close_block(load_.tets, r);
    for (const VertId v : used_) {
      load_.verts.items.push_back(
          {dist_.vert2gid[v], m.coords[v], m.vert_ref[v], m.vert_flags[v], static_cast<std::uint8_t>(shared_[v]), 0});
      load_.data.items.insert(load_.data.items.end(), dist_.data.at(v), dist_.data.at(v) + dist_.data.width);
    }
    close_block(load_.verts, r);
    close_block(load_.data, r);
    auto it = std::lower_bound(features_.begin(), features_.end(), FeatureUse{r, 0});
    for (; it != features_.end() && it->first == r; ++it) {
      const FeatureEdge& e = m.features.list()[it->second];
      load_.features.items.push_back({number_[e.a], number_[e.b], e.ref, e.ridge ? 1 : 0});
    }
    close_block(load_.features, r);
    for (const VertId v : used_) number_[v] = -1;
  }
  void pack_tet(TetId t, Rank r) {
    const TetMesh& m = dist_.mesh;
    MovedTet out{};
    for (std::size_t k = 0; k < 4; ++k) {
      const VertId v = m.tet2vert[t][k];
      if (number_[v] < 0) {
        number_[v] = static_cast<std::int32_t>(used_.size());
        used_.push_back(v);
      }
      out.vert[k] = number_[v];
      const FaceId f = m.tet2face[t][k];
      if (f == kNoFace) {
        out.face[k] = is_hull(m.face_tag[t][k]) ? kOpen : kWasInterface;
      } else {
        out.face[k] = dest_[face_tet(f)] == r ? 4 * ~leaving_.place[face_tet(f)] + face_side(f) : kOpen;
      }
    }
    out.tag = m.face_tag[t];
    out.ref = m.tet_ref[t];
    load_.tets.items.push_back(out);
  }

  const Comm& comm_;
  const DistMesh& dist_;
  const IdVector<TetId, Rank>& dest_;
  const Leaving& leaving_;
  const std::vector<FeatureUse>& features_;
  IdVector<VertId, char> shared_;
  IdVector<VertId, std::int32_t> number_;  ///< in the current block
  std::vector<VertId> used_;
  Load load_;
};

/// Faces and vertices that may find their other copy among what comes.
struct Seams {
  std::vector<FaceId> faces;
  std::vector<std::pair<GlobalId, VertId>> verts;
};

/// Moves the vertices of what stays to the front of their arrays, in place. Gives their new numbers.
IdVector<VertId, VertId> close_vertex_gaps(DistMesh& dist, const IdVector<TetId, Rank>& dest, bool all_stay, Rank me) {
  TetMesh& m = dist.mesh;
  IdVector<VertId, VertId> old2new(m.vert_slots(), all_stay ? VertId{0} : kNoVert);
  for (const TetId t : IdRange<TetId>(all_stay ? 0 : m.tet_slots())) {
    if (dest[t] != me) continue;
    for (const VertId v : m.tet2vert[t]) old2new[v] = VertId{0};
  }
  const auto width = static_cast<std::size_t>(dist.data.width);
  std::size_t nv = 0;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (old2new[v] == kNoVert) continue;
    const VertId w = old2new[v] = to_id<VertId>(nv++);
    if (w == v) continue;
    m.coords[w] = m.coords[v];
    m.vert_ref[w] = m.vert_ref[v];
    m.vert_flags[w] = m.vert_flags[v];
    dist.vert2gid[w] = dist.vert2gid[v];
    std::copy_n(dist.data.at(v), width, dist.data.at(w));
  }
  m.coords.resize(nv);
  return old2new;
}

/// Appends the faces that are on the interface.
void add_open_faces(const TetMesh& m, std::vector<FaceId>& faces) {
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (m.tet2face[t][k] == kNoFace && !is_hull(m.face_tag[t][k])) {
        faces.push_back(make_face(t, static_cast<int>(k)));
      }
    }
  }
}

/// Moves what stays to the front of all arrays, in place.
Seams close_gaps(DistMesh& dist, const IdVector<TetId, Rank>& dest, const Leaving& leaving,
                 const std::vector<FeatureUse>& features, Rank me) {
  TetMesh& m = dist.mesh;
  Seams seams;
  const bool all_stay = leaving.tets.empty();
  const auto old2new = close_vertex_gaps(dist, dest, all_stay, me);
  if (all_stay) add_open_faces(m, seams.faces);
  for (const TetId t : IdRange<TetId>(all_stay ? 0 : m.tet_slots())) {
    if (leaving.place[t] < 0) continue;
    const TetId s{leaving.place[t]};
    m.tet2vert[s] = m.tet2vert[t];
    for (auto& v : m.tet2vert[s]) v = old2new[v];
    m.face_tag[s] = m.face_tag[t];
    m.tet_ref[s] = m.tet_ref[t];
    for (std::size_t k = 0; k < 4; ++k) {
      FaceId f = m.tet2face[t][k];
      if (f == kNoFace) {
        if (!is_hull(m.face_tag[s][k])) seams.faces.push_back(make_face(s, static_cast<int>(k)));
      } else {
        const std::int32_t to = leaving.place[face_tet(f)];
        f = to >= 0 ? make_face(TetId{to}, face_side(f)) : kNoFace;
      }
      m.tet2face[s][k] = f;
    }
  }
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) {
    const VertId v = old2new[dist.sharing.vert[i]];
    if (v != kNoVert) seams.verts.emplace_back(dist.sharing.gid[i], v);
  }
  if (all_stay) return seams;
  FeatureEdges kept;
  auto it = std::lower_bound(features.begin(), features.end(), FeatureUse{me, 0});
  for (; it != features.end() && it->first == me; ++it) {
    const FeatureEdge& e = m.features.list()[it->second];
    kept.insert(old2new[e.a], old2new[e.b], e.ref, e.ridge);
  }
  m.features = std::move(kept);
  return seams;
}

/// To n items without room for more: growing an array the usual way doubles it.
template <class Vector>
void resize_exactly(Vector& v, std::size_t n) {
  v.reserve(n);
  v.resize(n);
}

void resize_all(DistMesh& dist, std::size_t nv, std::size_t nt) {
  TetMesh& m = dist.mesh;
  resize_exactly(m.coords, nv);
  resize_exactly(m.vert_ref, nv);
  resize_exactly(m.vert_flags, nv);
  resize_exactly(m.vert2tet, nv);
  m.vert2tet.assign(nv, kNoTet);
  resize_exactly(dist.vert2gid, nv);
  resize_exactly(dist.data.values, nv * static_cast<std::size_t>(dist.data.width));
  resize_exactly(m.tet2vert, nt);
  resize_exactly(m.tet2face, nt);
  resize_exactly(m.face_tag, nt);
  resize_exactly(m.tet_ref, nt);
}

/// Local numbers of the vertices that came: those that are here already by their global id, the others in order.
std::vector<VertId> number_incoming(const DistMesh& dist, const Packets<MovedVert>& verts, const Seams& seams,
                                    std::size_t& nv) {
  std::size_t candidates = seams.verts.size();
  for (const auto& v : verts.items) candidates += v.shared;
  GidMap shared(candidates);  // its numbers are places in shared2vert
  IdVector<VertId, VertId> shared2vert;
  for (const auto& [gid, v] : seams.verts) {
    shared.insert(gid);
    shared2vert.push_back(v);
  }
  nv = dist.mesh.coords.size();
  std::vector<VertId> number(verts.items.size());
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (verts.items[i].shared == 0) {
      number[i] = to_id<VertId>(nv++);
      continue;
    }
    const VertId s = shared.insert(verts.items[i].gid);
    if (s == shared2vert.end_id()) shared2vert.push_back(to_id<VertId>(nv++));
    number[i] = shared2vert[s];
  }
  return number;
}

/// Appends the tetrahedra, vertices and feature edges that came. Adds their interface faces to the seams.
void append(DistMesh& dist, const Load& load, const std::vector<VertId>& number, std::size_t stay, Seams& seams) {
  TetMesh& m = dist.mesh;
  const auto width = static_cast<std::size_t>(dist.data.width);
  for (std::size_t i = 0; i < number.size(); ++i) {
    const MovedVert& in = load.verts.items[i];
    const VertId v = number[i];
    const auto copies_here = m.vert_flags[v];  // 0 in new slots
    m.coords[v] = in.x;
    m.vert_ref[v] = in.ref;
    m.vert_flags[v] = static_cast<std::uint8_t>(copies_here | in.flags);
    dist.vert2gid[v] = in.gid;
    std::copy_n(load.data.items.data() + i * width, width, dist.data.at(v));
  }
  // Every block of tetrahedra has a block of vertices from the same rank.
  std::size_t feature_block = 0;
  for (std::size_t b = 0; b < load.tets.blocks(); ++b) {
    const VertId* vert = number.data() + load.verts.offset[b];
    const auto base = static_cast<std::int32_t>(stay + load.tets.offset[b]);
    for (std::size_t i = load.tets.offset[b]; i < load.tets.offset[b + 1]; ++i) {
      const MovedTet& in = load.tets.items[i];
      const TetId t = to_id<TetId>(stay + i);
      for (std::size_t k = 0; k < 4; ++k) {
        m.tet2vert[t][k] = vert[in.vert[k]];
        m.tet2face[t][k] = in.face[k] >= 0 ? FaceId{4 * base + in.face[k]} : kNoFace;
        if (in.face[k] == kWasInterface) seams.faces.push_back(make_face(t, static_cast<int>(k)));
      }
      m.face_tag[t] = in.tag;
      m.tet_ref[t] = in.ref;
    }
    if (feature_block < load.features.blocks() && load.features.rank[feature_block] == load.tets.rank[b]) {
      for (const auto& e : load.features.block(feature_block)) {
        const auto [a, c] = std::minmax(vert[e.a], vert[e.b]);
        m.features.insert(a, c, e.ref, e.ridge != 0);
      }
      ++feature_block;
    }
  }
}

/// Links faces that were on the interface and have both sides here now.
void link_seams(TetMesh& m, const std::vector<FaceId>& faces) {
  struct Seam {
    std::array<VertId, 3> v;
    FaceId face;
  };
  std::vector<Seam> list(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    list[i] = {face_verts(m, faces[i]), faces[i]};
    std::sort(list[i].v.begin(), list[i].v.end());
  }
  std::sort(list.begin(), list.end(),
            [](const Seam& a, const Seam& b) { return a.v != b.v ? a.v < b.v : a.face < b.face; });
  for (std::size_t i = 0; i + 1 < list.size(); ++i) {
    if (list[i].v != list[i + 1].v) continue;
    const FaceId f = list[i].face, g = list[i + 1].face;
    m.tet2face[face_tet(f)][static_cast<std::size_t>(face_side(f))] = g;
    m.tet2face[face_tet(g)][static_cast<std::size_t>(face_side(g))] = f;
    ++i;
  }
}

}  // namespace

void migrate(const Comm& comm, DistMesh& dist, const IdVector<TetId, Rank>& dest) {
  agree(comm, [&] {
    if (dest.size() != dist.mesh.tet_slots() ||
        std::any_of(dest.begin(), dest.end(), [&](Rank r) { return num(r) < 0 || num(r) >= comm.size(); }))
      throw Error(ExitCode::kInternal, "migrate: destinations do not fit the tetrahedra or the ranks");
    if (std::count(dist.vert2gid.begin(), dist.vert2gid.end(), kNoGlobal) != 0)
      throw Error(ExitCode::kInternal, "migrate: vertices without global id (number_new_vertices comes first)");
  });
  const Leaving leaving = sort_out(comm, dest);
  const auto features = leaving.tets.empty() ? std::vector<FeatureUse>() : features_by_rank(dist.mesh, dest);
  Load in;
  {
    const Load out = Packer(comm, dist, dest, leaving, features).pack();
    in.tets = exchange(comm, out.tets);
    in.verts = exchange(comm, out.verts);
    in.data = exchange(comm, out.data);
    in.features = exchange(comm, out.features);
  }
  Seams seams = close_gaps(dist, dest, leaving, features, comm.rank());
  std::size_t nv = 0;
  const auto number = number_incoming(dist, in.verts, seams, nv);
  const std::size_t stayed_verts = dist.mesh.coords.size();
  resize_all(dist, stayed_verts, leaving.stay);  // so that what comes finds cleared slots
  resize_all(dist, nv, leaving.stay + in.tets.items.size());
  append(dist, in, number, leaving.stay, seams);
  link_seams(dist.mesh, seams.faces);
  for (const TetId t : IdRange<TetId>(dist.mesh.tet_slots())) {
    for (const VertId v : dist.mesh.tet2vert[t]) dist.mesh.vert2tet[v] = t;
  }
  rebuild_sharing(comm, dist);
  merge_vertex_flags(comm, dist);
  count_global(comm, dist);
}

}  // namespace skein
