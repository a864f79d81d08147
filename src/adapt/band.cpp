// Cutting the band out and putting it back, in place.
#include "adapt/band.hpp"

#include <algorithm>
#include <array>

namespace skein {
namespace {

/// Per vertex 0, or 1 + its distance in edges from the nearest active vertex, up to `layers`.
IdVector<VertId, std::uint8_t> near_active(const TetMesh& m, int layers) {
  IdVector<VertId, std::uint8_t> level(m.vert_slots(), 0);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) level[v] = m.has(v, kActive) ? 1 : 0;
  for (int l = 1; l <= layers; ++l) {
    const auto next = static_cast<std::uint8_t>(l + 1);
    for (const auto& tv : m.tet2vert) {
      const auto inside = [&](VertId v) { return level[v] != 0 && level[v] < next; };
      if (!inside(tv[0]) && !inside(tv[1]) && !inside(tv[2]) && !inside(tv[3])) continue;
      for (const VertId v : tv) {
        if (level[v] == 0) level[v] = next;
      }
    }
  }
  return level;
}

void cut_vertex(const TetMesh& m, const VertexAttributes& data, VertId v, bool inner, Band& band) {
  band.mesh.coords.push_back(m.coords[v]);
  band.mesh.vert_ref.push_back(m.vert_ref[v]);
  band.mesh.vert_flags.push_back(static_cast<std::uint8_t>(m.vert_flags[v] | (inner ? 0 : kFrozen)));
  band.mesh.vert2tet.push_back(kNoTet);
  band.metric.push_back_log(data.log_metric(v));
  band.to_rank.push_back(v);
}

void cut_features(const TetMesh& m, TetId t, const std::array<VertId, 4>& in_band, Band& band) {
  const auto& tv = m.tet2vert[t];
  for (const auto& e : kEdgeVerts) {
    const auto a = static_cast<std::size_t>(e[0]), b = static_cast<std::size_t>(e[1]);
    if (!m.has(tv[a], kRidge | kCorner) || !m.has(tv[b], kRidge | kCorner)) continue;
    const FeatureEdge* f = m.features.find(tv[a], tv[b]);
    if (f == nullptr || band.mesh.features.find(in_band[a], in_band[b]) != nullptr) continue;
    band.mesh.features.insert(in_band[a], in_band[b], f->ref, f->ridge);
    band.features.push_back(*f);
  }
}

/// Puts a band back; the steps share the numbers of what comes in.
class Return {
 public:
  Return(TetMesh& mesh, VertexAttributes& data, const Band& band) : m_(mesh), data_(data), band_(band), b_(band.mesh) {}

  void run(const IdVector<VertId, VertId>& old2new) {
    for (const FeatureEdge& e : band_.features) m_.features.erase(e.a, e.b);
    place_vertices(old2new);
    place_tets();
    close_seam();
    for (const FeatureEdge& e : b_.features.list()) m_.features.insert(vert_[e.a], vert_[e.b], e.ref, e.ridge);
    fill_free_tets();
    fill_free_verts();
  }

 private:
  void place_vertices(const IdVector<VertId, VertId>& old2new) {
    vert_.assign(b_.vert_slots(), kNoVert);
    for (const VertId v : IdRange<VertId>(old2new.size())) {
      if (old2new[v] != kNoVert) vert_[old2new[v]] = band_.to_rank[v];
      if (old2new[v] == kNoVert) free_verts_.push_back(band_.to_rank[v]);
    }
    std::sort(free_verts_.begin(), free_verts_.end());
    const auto kept =
        static_cast<std::size_t>(std::count_if(vert_.begin(), vert_.end(), [](VertId v) { return v != kNoVert; }));
    const std::size_t fresh = b_.vert_slots() - kept;
    if (fresh > free_verts_.size()) reserve_verts(m_.vert_slots() + fresh - free_verts_.size());
    std::size_t next = 0;
    for (const VertId v : IdRange<VertId>(b_.vert_slots())) {
      if (vert_[v] != kNoVert) continue;
      vert_[v] = next < free_verts_.size() ? free_verts_[next++] : add_vertex();
      copy_vertex(v, vert_[v]);
    }
    free_verts_.erase(free_verts_.begin(), free_verts_.begin() + static_cast<std::ptrdiff_t>(next));
  }

  void reserve_verts(std::size_t n) {
    m_.coords.reserve(n);
    m_.vert_ref.reserve(n);
    m_.vert_flags.reserve(n);
    m_.vert2tet.reserve(n);
    data_.reserve(n);
  }

  VertId add_vertex() {
    m_.coords.push_back({});
    m_.vert_ref.push_back(0);
    m_.vert_flags.push_back(0);
    m_.vert2tet.push_back(kNoTet);
    data_.resize(m_.vert_slots());
    return to_id<VertId>(m_.vert_slots() - 1);
  }

  void copy_vertex(VertId from, VertId to) {
    m_.coords[to] = b_.coords[from];
    m_.vert_ref[to] = b_.vert_ref[from];
    m_.vert_flags[to] = b_.vert_flags[from];
    data_.set(to, band_.metric, from);
  }

  void place_tets() {
    const std::size_t n = b_.tet_slots(), places = std::min(n, band_.tets.size());
    tet_.assign(n, kNoTet);
    for (std::size_t i = 0; i < places; ++i) tet_[to_id<TetId>(i)] = band_.tets[i];
    for (std::size_t i = places; i < n; ++i) tet_[to_id<TetId>(i)] = to_id<TetId>(m_.tet_slots() + i - places);
    free_tets_.assign(band_.tets.begin() + static_cast<std::ptrdiff_t>(places), band_.tets.end());
    resize_tets(m_.tet_slots() + n - places);
    for (const TetId t : IdRange<TetId>(n)) {
      const TetId to = tet_[t];
      for (std::size_t k = 0; k < 4; ++k) {
        const VertId v = vert_[b_.tet2vert[t][k]];
        m_.tet2vert[to][k] = v;
        m_.vert2tet[v] = to;
        const FaceId f = b_.tet2face[t][k];
        m_.tet2face[to][k] = f == kNoFace ? kNoFace : make_face(tet_[face_tet(f)], face_side(f));
      }
      m_.face_tag[to] = b_.face_tag[t];
      m_.tet_ref[to] = b_.tet_ref[t];
    }
  }

  void resize_tets(std::size_t n) {
    if (n > m_.tet_slots()) {  // no more than that: growing the usual way doubles
      m_.tet2vert.reserve(n);
      m_.tet2face.reserve(n);
      m_.face_tag.reserve(n);
      m_.tet_ref.reserve(n);
    }
    m_.tet2vert.resize(n);
    m_.tet2face.resize(n);
    m_.face_tag.resize(n);
    m_.tet_ref.resize(n);
  }

  /// Links the faces of the rest with those of the band. Faces of the band without a partner are on the interface
  /// between ranks.
  void close_seam() {
    struct Side {
      std::array<VertId, 3> v;
      FaceId face;
    };
    std::vector<Side> sides;
    const auto add = [&](FaceId f) {
      sides.push_back({face_verts(m_, f), f});
      std::sort(sides.back().v.begin(), sides.back().v.end());
    };
    for (const FaceId f : band_.seam) add(f);
    for (const TetId t : tet_) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (m_.tet2face[t][k] == kNoFace && !is_hull(m_.face_tag[t][k])) add(make_face(t, static_cast<int>(k)));
      }
    }
    std::sort(sides.begin(), sides.end(),
              [](const Side& a, const Side& b) { return a.v != b.v ? a.v < b.v : a.face < b.face; });
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      if (sides[i].v != sides[i + 1].v) continue;
      link(sides[i].face, sides[i + 1].face);
      ++i;
    }
  }
  void link(FaceId f, FaceId g) {
    m_.tet2face[face_tet(f)][static_cast<std::size_t>(face_side(f))] = g;
    m_.tet2face[face_tet(g)][static_cast<std::size_t>(face_side(g))] = f;
  }

  /// The places `free` (ascending) of n are taken by what lies at the end: calls move(from, to); gives what n becomes.
  template <class Id, class Move>
  static std::size_t fill_holes(const std::vector<Id>& free, std::size_t n, Move&& move) {
    std::size_t hole = 0, holes = free.size();
    while (hole < holes) {
      const Id last = to_id<Id>(--n);
      if (free[holes - 1] == last) {
        --holes;
      } else {
        move(last, free[hole++]);
      }
    }
    return n;
  }

  void fill_free_tets() {
    resize_tets(fill_holes(free_tets_, m_.tet_slots(), [&](TetId from, TetId to) { move_tet(from, to); }));
  }
  void move_tet(TetId from, TetId to) {
    m_.tet2vert[to] = m_.tet2vert[from];
    m_.tet2face[to] = m_.tet2face[from];
    m_.face_tag[to] = m_.face_tag[from];
    m_.tet_ref[to] = m_.tet_ref[from];
    for (const VertId v : m_.tet2vert[to]) m_.vert2tet[v] = to;
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceId f = m_.tet2face[to][k];
      if (f != kNoFace) link(f, make_face(to, static_cast<int>(k)));
    }
  }

  void fill_free_verts() {
    if (free_verts_.empty()) return;
    const std::size_t first = m_.vert_slots() - free_verts_.size();  // what lies behind goes into the holes before it
    IdVector<VertId, VertId> old2new(free_verts_.size(), kNoVert);
    const std::size_t n = fill_holes(free_verts_, m_.vert_slots(), [&](VertId from, VertId to) {
      move_vertex(from, to);
      old2new[to_id<VertId>(idx(from) - first)] = to;
    });
    follow(old2new, first);
    m_.coords.resize(n);
    m_.vert_ref.resize(n);
    m_.vert_flags.resize(n);
    m_.vert2tet.resize(n);
    data_.resize(n);
  }
  void move_vertex(VertId from, VertId to) {
    m_.coords[to] = m_.coords[from];
    m_.vert_ref[to] = m_.vert_ref[from];
    m_.vert_flags[to] = m_.vert_flags[from];
    m_.vert2tet[to] = m_.vert2tet[from];
    data_.move(from, to);
  }
  void follow(const IdVector<VertId, VertId>& old2new, std::size_t first) {
    const auto now = [&](VertId v) { return idx(v) < first ? v : old2new[to_id<VertId>(idx(v) - first)]; };
    for (auto& tv : m_.tet2vert) {
      for (auto& v : tv) v = now(v);
    }
    for (auto& v : data_.kept()) v = now(v);
    const std::vector<FeatureEdge> edges = m_.features.list();
    for (const FeatureEdge& e : edges) {
      if (idx(e.a) < first && idx(e.b) < first) continue;
      m_.features.erase(e.a, e.b);
      m_.features.insert(now(e.a), now(e.b), e.ref, e.ridge);
    }
  }

  TetMesh& m_;
  VertexAttributes& data_;
  const Band& band_;
  const TetMesh& b_;
  IdVector<VertId, VertId> vert_;  ///< of the band -> of the rank
  IdVector<TetId, TetId> tet_;
  std::vector<VertId> free_verts_;  ///< ascending
  std::vector<TetId> free_tets_;
};

/// What goes with the vertices of a rank's mesh.
class RankVertices final : public VertexAttributes {
 public:
  explicit RankVertices(DistMesh& dist) : dist_(dist) {}
  [[nodiscard]] SymTensor log_metric(VertId v) const override {
    const double* d = dist_.data.at(v);
    return {d[0], d[1], d[2], d[3], d[4], d[5]};
  }
  void reserve(std::size_t n) override {
    dist_.vert2gid.reserve(n);
    dist_.data.values.reserve(n * width());
  }
  void resize(std::size_t n) override {
    dist_.vert2gid.resize(n, kNoGlobal);
    dist_.data.values.resize(n * width());
  }
  void set(VertId to, const MetricField& metric, VertId from) override {
    dist_.vert2gid[to] = kNoGlobal;
    const SymTensor& l = metric.log_at[from];
    double* d = dist_.data.at(to);
    d[0] = l.xx, d[1] = l.xy, d[2] = l.yy, d[3] = l.xz, d[4] = l.yz, d[5] = l.zz;
  }
  void move(VertId from, VertId to) override {
    dist_.vert2gid[to] = dist_.vert2gid[from];
    std::copy_n(dist_.data.at(from), width(), dist_.data.at(to));
  }
  std::span<VertId> kept() override { return dist_.sharing.vert; }

 private:
  [[nodiscard]] std::size_t width() const noexcept { return static_cast<std::size_t>(dist_.data.width); }
  DistMesh& dist_;
};

}  // namespace

Band cut_band(DistMesh& dist, int layers) { return cut_band(dist.mesh, RankVertices(dist), layers); }

void put_back(DistMesh& dist, const Band& band, const IdVector<VertId, VertId>& old2new) {
  RankVertices data(dist);
  put_back(dist.mesh, data, band, old2new);
}

Band cut_band(const TetMesh& m, const VertexAttributes& data, int layers) {
  const auto level = near_active(m, layers);
  Band band;
  IdVector<TetId, TetId> tet2band(m.tet_slots(), kNoTet);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& tv = m.tet2vert[t];
    if ((level[tv[0]] | level[tv[1]] | level[tv[2]] | level[tv[3]]) == 0) continue;
    tet2band[t] = to_id<TetId>(band.tets.size());
    band.tets.push_back(t);
  }
  IdVector<VertId, VertId> vert2band(m.vert_slots(), kNoVert);
  TetMesh& b = band.mesh;
  for (const TetId t : band.tets) {
    std::array<VertId, 4> tv;
    std::array<FaceId, 4> tf;
    for (std::size_t k = 0; k < 4; ++k) {
      const VertId v = m.tet2vert[t][k];
      if (vert2band[v] == kNoVert) {
        vert2band[v] = b.coords.end_id();
        // A tetrahedron outside has no vertex near an active one, so whatever it shares with the band is frozen.
        cut_vertex(m, data, v, level[v] != 0, band);
      }
      tv[k] = vert2band[v];
      const FaceId f = m.tet2face[t][k];
      const TetId other = f == kNoFace ? kNoTet : tet2band[face_tet(f)];
      if (f != kNoFace && other == kNoTet) band.seam.push_back(f);
      tf[k] = other == kNoTet ? kNoFace : make_face(other, face_side(f));
    }
    const TetId bt = b.tet2vert.push_back(tv);
    b.tet2face.push_back(tf);
    for (const VertId v : tv) b.vert2tet[v] = bt;
    b.face_tag.push_back(m.face_tag[t]);
    b.tet_ref.push_back(m.tet_ref[t]);
    cut_features(m, t, tv, band);
  }
  b.patch_ref = m.patch_ref;
  return band;
}

void put_back(TetMesh& mesh, VertexAttributes& data, const Band& band, const IdVector<VertId, VertId>& old2new) {
  Return(mesh, data, band).run(old2new);
}

}  // namespace skein
