// Cutting the band out and putting it back, in place.
#include "adapt/band.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>

namespace skein {
namespace {

/// What lies round some vertices, found from them over faces.
class Surroundings {
 public:
  Surroundings(const TetMesh& m, const std::vector<VertId>& verts)
      : m_(m), seen_(m.vert_slots(), 0), inside_(m.tet_slots(), 0), verts_(verts) {
    for (const VertId v : verts_) {
      seen_[v] = 1;
      enter(m.vert2tet[v]);
    }
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
  [[nodiscard]] std::size_t tets() const noexcept { return tets_.size(); }

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

void cut_vertex(const TetMesh& m, const VertexAttributes& data, VertId v, bool inner, Band& band) {
  band.mesh.coords.push_back(m.coords[v]);
  band.mesh.vert_ref.push_back(m.vert_ref[v]);
  band.mesh.vert_flags.push_back(static_cast<std::uint8_t>((m.vert_flags[v] & ~kActive) | (inner ? 0 : kFrozen)));
  band.mesh.vert2tet.push_back(kNoTet);
  data.append_metric(v, band.metric);
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
      if (old2new[v] != kNoVert) keep_vertex(band_.to_rank[v], old2new[v]);
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

  void keep_vertex(VertId v, VertId in_band) {
    vert_[in_band] = v;
    m_.vert_flags[v] = static_cast<std::uint8_t>((m_.vert_flags[v] & ~kHeld) | (b_.vert_flags[in_band] & kHeld));
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
  void append_metric(VertId v, MetricField& to) const override {
    const double* d = dist_.data.at(v);
    to.push_back_log({d[0], d[1], d[2], d[3], d[4], d[5]});
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

std::vector<VertId> active_near(const TetMesh& m, const std::vector<VertId>& verts, int layers) {
  Surroundings near(m, verts);
  for (int l = 0; l < layers; ++l) {
    near.add_tets();
    near.add_vertices();
  }
  std::vector<VertId> out;
  std::copy_if(near.verts().begin(), near.verts().end(), std::back_inserter(out),
               [&](VertId v) { return m.has(v, kActive); });
  return out;
}

Band cut_band(DistMesh& dist, const std::vector<VertId>& active, int layers) {
  return cut_band(dist.mesh, RankVertices(dist), active, layers);
}

Band cut_band(DistMesh& dist, int layers) {
  std::vector<VertId> active;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    if (dist.mesh.has(v, kActive)) active.push_back(v);
  }
  return cut_band(dist, active, layers);
}

void put_back(DistMesh& dist, const Band& band, const IdVector<VertId, VertId>& old2new) {
  RankVertices data(dist);
  put_back(dist.mesh, data, band, old2new);
}

Band cut_band(const TetMesh& m, const VertexAttributes& data, const std::vector<VertId>& active, int layers) {
  Surroundings near(m, active);
  for (int l = 0; l < layers; ++l) {
    near.add_tets();
    near.add_vertices();
  }
  near.add_tets();
  Band band;
  band.tets.reserve(near.tets());
  const auto tet2band = std::make_unique_for_overwrite<TetId[]>(m.tet_slots());  // of what is inside
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!near.has(t)) continue;
    tet2band[idx(t)] = to_id<TetId>(band.tets.size());
    band.tets.push_back(t);
  }
  IdVector<VertId, VertId> vert2band(m.vert_slots(), kNoVert);
  TetMesh& b = band.mesh;
  b.reserve(2 * near.verts().size(), band.tets.size());
  for (const TetId t : band.tets) {
    std::array<VertId, 4> tv;
    std::array<FaceId, 4> tf;
    for (std::size_t k = 0; k < 4; ++k) {
      const VertId v = m.tet2vert[t][k];
      if (vert2band[v] == kNoVert) {
        vert2band[v] = b.coords.end_id();
        // A tetrahedron outside has no vertex near an active one, so whatever it shares with the band is frozen.
        cut_vertex(m, data, v, near.has(v), band);
      }
      tv[k] = vert2band[v];
      const FaceId f = m.tet2face[t][k];
      const TetId other = f == kNoFace || !near.has(face_tet(f)) ? kNoTet : tet2band[idx(face_tet(f))];
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
  for (const VertId v : active) b.vert_flags[vert2band[v]] |= kActive;
  b.patch_ref = m.patch_ref;
  return band;
}

void put_back(TetMesh& mesh, VertexAttributes& data, const Band& band, const IdVector<VertId, VertId>& old2new) {
  Return(mesh, data, band).run(old2new);
}

}  // namespace skein
