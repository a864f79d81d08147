// Cutting the band out and putting it back, in place.
#include "adapt/band.hpp"

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"
#include "base/subset.hpp"
#include "dist/feature_scan.hpp"
#include "mesh/free_slots.hpp"

namespace skein {
namespace {

/// Cuts a band; threads share what comes in by its place in the band.
class Cut {
 public:
  Cut(const TetMesh& m, const VertexAttributes& data, Surroundings near, int threads)
      : m_(m), data_(data), near_(std::move(near)), threads_(threads), tets_(m.tet_slots()), verts_(m.vert_slots()) {}

  Band run() {
    near_.add_tets();
    number();
    in_parallel(threads_, [&](int w) { place_vertices(w); });
    std::vector<std::vector<FaceId>> seams(static_cast<std::size_t>(threads_));
    in_parallel(threads_, [&](int w) { place_tets(w, seams[w]); });
    for (const auto& seam : seams) band_.seam.insert(band_.seam.end(), seam.begin(), seam.end());
    TetMesh& b = band_.mesh;
    for (const TetId t : IdRange<TetId>(b.tet_slots())) {
      for (const VertId v : b.tet2vert[t]) b.vert2tet[v] = t;
    }
    if (m_.features.size() != 0) cut_features();
    b.patch_ref = m_.patch_ref;
    return std::move(band_);
  }

 private:
  void number() {
    band_.tets = near_.tets();
    for (const TetId t : band_.tets) {
      tets_.insert(t);
      for (const VertId v : m_.tet2vert[t]) verts_.insert(v);
    }
    tets_.number();
    verts_.number();
    band_.to_rank = IdVector<VertId, VertId>(verts_.members());
    const std::size_t nt = band_.tets.size(), nv = verts_.size();
    TetMesh& b = band_.mesh;
    b.reserve(2 * nv, nt);
    band_.metric.reserve(2 * nv);
    resize_tets(b, nt);
    resize_verts(b, nv);
    band_.metric.at.resize(nv);
    band_.metric.log_at.resize(nv);
  }

  void place_vertices(int w) {
    const std::size_t n = verts_.size(), begin = share_begin(n, w, threads_), end = share_begin(n, w + 1, threads_);
    data_.copy_metrics(std::span<const VertId>(band_.to_rank.raw()).subspan(begin, end - begin), band_.metric,
                       to_id<VertId>(begin));
    for (const VertId to : IdRange<VertId>(begin, end)) {
      const VertId v = band_.to_rank[to];
      band_.mesh.coords[to] = m_.coords[v];
      band_.mesh.vert_ref[to] = m_.vert_ref[v];
      // A tetrahedron outside has no vertex that is in near_, so whatever it shares with the band is frozen.
      const unsigned flags = near_.has(v) ? m_.vert_flags[v] : (m_.vert_flags[v] & ~kActive) | kFrozen;
      band_.mesh.vert_flags[to] = static_cast<std::uint8_t>(flags);
    }
  }

  void place_tets(int w, std::vector<FaceId>& seam) {
    const std::size_t n = band_.tets.size();
    for (const TetId to : IdRange<TetId>(share_begin(n, w, threads_), share_begin(n, w + 1, threads_))) {
      const TetId t = band_.tets[idx(to)];
      for (std::size_t k = 0; k < 4; ++k) {
        band_.mesh.tet2vert[to][k] = to_id<VertId>(verts_.place(m_.tet2vert[t][k]));
        const FaceId f = m_.tet2face[t][k];
        const bool inside = f != kNoFace && tets_.has(face_tet(f));
        if (f != kNoFace && !inside) seam.push_back(f);
        band_.mesh.tet2face[to][k] = inside ? make_face(to_id<TetId>(tets_.place(face_tet(f))), face_side(f)) : kNoFace;
      }
      band_.mesh.face_tag[to] = m_.face_tag[t];
      band_.mesh.tet_ref[to] = m_.tet_ref[t];
    }
  }

  void cut_features() {
    for (const TetId t : band_.tets) {
      features_of(m_, t, [&](std::uint32_t place) {
        const FeatureEdge& e = m_.features.list()[place];
        const auto a = to_id<VertId>(verts_.place(e.a)), b = to_id<VertId>(verts_.place(e.b));
        if (band_.mesh.features.find(a, b) != nullptr) return;
        band_.mesh.features.insert(a, b, e.ref, e.ridge);
        band_.features.push_back(e);
      });
    }
  }

  const TetMesh& m_;
  const VertexAttributes& data_;
  Surroundings near_;
  int threads_;
  Subset<TetId> tets_;
  Subset<VertId> verts_;
  Band band_;
};

/// Puts a band back; the steps share the numbers of what comes in.
class Return {
 public:
  Return(TetMesh& mesh, VertexAttributes& data, const Band& band, int threads)
      : m_(mesh), data_(data), band_(band), b_(band.mesh), threads_(threads) {}

  void run(const IdVector<VertId, VertId>& old2new) {
    for (const FeatureEdge& e : band_.features) m_.features.erase(e.a, e.b);
    place_vertices(old2new);
    place_tets();
    for (const FeatureEdge& e : b_.features.list()) m_.features.insert(vert_[e.a], vert_[e.b], e.ref, e.ridge);
    fill_free_places();
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
    const std::size_t fresh = b_.vert_slots() - kept, before = m_.vert_slots();
    if (fresh > free_verts_.size()) {
      resize_verts(m_, before + fresh - free_verts_.size());
      data_.reserve(m_.vert_slots());
      data_.resize(m_.vert_slots());
    }
    std::size_t next = 0, end = before;
    for (const VertId v : IdRange<VertId>(b_.vert_slots())) {
      if (vert_[v] != kNoVert) continue;
      vert_[v] = next < free_verts_.size() ? free_verts_[next++] : to_id<VertId>(end++);
      copy_vertex(v, vert_[v]);
    }
    free_verts_.erase(free_verts_.begin(), free_verts_.begin() + static_cast<std::ptrdiff_t>(next));
  }

  void keep_vertex(VertId v, VertId in_band) {
    vert_[in_band] = v;
    const unsigned now = b_.vert_flags[in_band] & (kBesideFrozen | kRetry);
    // What the band has only in part may be poor for the sake of the rest.
    const unsigned keep = b_.has(in_band, kActive) ? ~(kBesideFrozen | kRetry) : ~static_cast<unsigned>(kRetry);
    m_.vert_flags[v] = static_cast<std::uint8_t>((m_.vert_flags[v] & keep) | now);
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
    resize_tets(m_, m_.tet_slots() + n - places);
    for (const VertId v : IdRange<VertId>(b_.vert_slots())) m_.vert2tet[vert_[v]] = tet_[b_.vert2tet[v]];
    std::vector<std::vector<FaceId>> open(static_cast<std::size_t>(threads_));
    in_parallel(threads_, [&](int w) { place_tets(w, open[w]); });
    close_seam(open);
  }

  /// Thread w's share. `open`: faces without a neighbour.
  void place_tets(int w, std::vector<FaceId>& open) {
    const std::size_t n = b_.tet_slots();
    for (const TetId t : IdRange<TetId>(share_begin(n, w, threads_), share_begin(n, w + 1, threads_))) {
      const TetId to = tet_[t];
      for (std::size_t k = 0; k < 4; ++k) {
        m_.tet2vert[to][k] = vert_[b_.tet2vert[t][k]];
        const FaceId f = b_.tet2face[t][k];
        m_.tet2face[to][k] = f == kNoFace ? kNoFace : make_face(tet_[face_tet(f)], face_side(f));
        if (f == kNoFace && !is_hull(b_.face_tag[t][k])) open.push_back(make_face(to, k));
      }
      m_.face_tag[to] = b_.face_tag[t];
      m_.tet_ref[to] = b_.tet_ref[t];
    }
  }

  /// Links the faces of the rest with those of the band. Faces of the band without a partner are on the interface
  /// between ranks.
  void close_seam(const std::vector<std::vector<FaceId>>& open) {
    std::vector<FaceId> sides = band_.seam;
    for (const auto& faces : open) sides.insert(sides.end(), faces.begin(), faces.end());
    link_equal_faces(m_, sides);
  }

  void fill_free_places() {
    fill_free_tets(m_, free_tets_);
    const MovedVerts now = fill_free_verts(
        m_, free_verts_, [&](VertId from, VertId to) { data_.move(from, to); }, threads_);
    data_.resize(m_.vert_slots());
    for (auto& v : data_.kept()) v = now(v);
  }

  TetMesh& m_;
  VertexAttributes& data_;
  const Band& band_;
  const TetMesh& b_;
  int threads_;
  IdVector<VertId, VertId> vert_;  ///< of the band -> of the rank
  IdVector<TetId, TetId> tet_;
  std::vector<VertId> free_verts_;  ///< ascending
  std::vector<TetId> free_tets_;
};

/// What goes with the vertices of a rank's mesh.
class RankVertices final : public VertexAttributes {
 public:
  explicit RankVertices(DistMesh& dist) : dist_(dist) {}
  void copy_metrics(std::span<const VertId> from, MetricField& field, VertId first) const override {
    for (std::size_t i = 0; i < from.size(); ++i)
      field.log_at[to_id<VertId>(idx(first) + i)] = log_metric_at(dist_, from[i]);
    field.measure(first, from.size());
  }
  void reserve(std::size_t n) override {
    reserve_with_slack(dist_.vert2gid, n);
    reserve_with_slack(dist_.data.values, n * width());
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

Band cut_band(const TetMesh& mesh, const VertexAttributes& data, Surroundings near, int threads) {
  return Cut(mesh, data, std::move(near), threads).run();
}

Band cut_band(DistMesh& dist, int layers, int threads) {
  std::vector<VertId> active;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    if (dist.mesh.has(v, kActive)) active.push_back(v);
  }
  Surroundings near(dist.mesh, std::move(active));
  for (int l = 0; l < layers; ++l) {
    near.add_tets();
    near.add_vertices();
  }
  return cut_band(dist.mesh, RankVertices(dist), std::move(near), threads);
}

void put_back(TetMesh& mesh, VertexAttributes& data, const Band& band, const IdVector<VertId, VertId>& old2new,
              int threads) {
  Return(mesh, data, band, threads).run(old2new);
}

void put_back(DistMesh& dist, const Band& band, const IdVector<VertId, VertId>& old2new, int threads) {
  RankVertices data(dist);
  put_back(dist.mesh, data, band, old2new, threads);
}

}  // namespace skein
