// Cutting the band out and putting it back, in place.
#include "adapt/band.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>

#include "mesh/holes.hpp"
#include "mesh/surroundings.hpp"
#include "partition/feature_scan.hpp"

namespace skein {
namespace {

void cut_vertex(const TetMesh& m, const VertexAttributes& data, VertId v, bool inner, Band& band) {
  band.mesh.coords.push_back(m.coords[v]);
  band.mesh.vert_ref.push_back(m.vert_ref[v]);
  band.mesh.vert_flags.push_back(static_cast<std::uint8_t>((m.vert_flags[v] & ~kActive) | (inner ? 0 : kFrozen)));
  band.mesh.vert2tet.push_back(kNoTet);
  data.append_metric(v, band.metric);
  band.to_rank.push_back(v);
}

void cut_features(const TetMesh& m, TetId t, const IdVector<VertId, VertId>& vert2band, Band& band) {
  features_of(m, t, [&](std::uint32_t place) {
    const FeatureEdge& e = m.features.list()[place];
    const VertId a = vert2band[e.a], b = vert2band[e.b];
    if (band.mesh.features.find(a, b) != nullptr) return;
    band.mesh.features.insert(a, b, e.ref, e.ridge);
    band.features.push_back(e);
  });
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
    resize_tets(m_, m_.tet_slots() + n - places);
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

  /// Links the faces of the rest with those of the band. Faces of the band without a partner are on the interface
  /// between ranks.
  void close_seam() {
    std::vector<FaceId> sides = band_.seam;
    for (const TetId t : tet_) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (m_.tet2face[t][k] == kNoFace && !is_hull(m_.face_tag[t][k]))
          sides.push_back(make_face(t, static_cast<int>(k)));
      }
    }
    link_equal_faces(m_, sides);
  }

  void fill_free_places() {
    fill_free_tets(m_, free_tets_);
    const MovedVerts now = fill_free_verts(m_, free_verts_, [&](VertId from, VertId to) { data_.move(from, to); });
    data_.resize(m_.vert_slots());
    for (auto& v : data_.kept()) v = now(v);
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
  band.tets = near.tets();
  const auto tet2band = std::make_unique_for_overwrite<TetId[]>(m.tet_slots());  // of what is inside
  for (std::size_t i = 0; i < band.tets.size(); ++i) tet2band[idx(band.tets[i])] = to_id<TetId>(i);
  IdVector<VertId, VertId> vert2band(m.vert_slots(), kNoVert);
  TetMesh& b = band.mesh;
  b.reserve(2 * near.verts().size(), band.tets.size());
  band.metric.reserve(2 * near.verts().size());
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
    if (m.features.size() != 0) cut_features(m, t, vert2band, band);
  }
  for (const VertId v : active) b.vert_flags[vert2band[v]] |= kActive;
  b.patch_ref = m.patch_ref;
  return band;
}

void put_back(TetMesh& mesh, VertexAttributes& data, const Band& band, const IdVector<VertId, VertId>& old2new) {
  Return(mesh, data, band).run(old2new);
}

}  // namespace skein
