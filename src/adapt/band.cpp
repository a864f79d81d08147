// Cutting the band out and putting it back, in place.
#include "adapt/band.hpp"

#include <algorithm>
#include <utility>

#include "base/assert.hpp"
#include "base/parallel.hpp"
#include "base/subset.hpp"
#include "dist/feature_scan.hpp"
#include "mesh/check.hpp"
#include "mesh/free_slots.hpp"

namespace skein {
namespace {

/// Cuts a band; threads share what comes in by its place in the band.
class Cut {
 public:
  Cut(const TetMesh& m, Surroundings near, int threads)
      : m_(m), near_(std::move(near)), threads_(threads), tets_(m.tet_slots()), verts_(m.vert_slots()) {}

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
    resize_tets(b, nt);
    for_each_vert_column(b, m_, [&](auto& to, const auto& from) { make_column(to, from, nv); });
    if (m_.metric.empty()) make_column(b.metric, nv);
    b.vert2tet.reserve(kRoom * nv);
    b.vert2tet.resize(nv);
  }

  /// A column with n entries and room for what adapting adds, if there is one to be cut from.
  template <class Column>
  static void make_column(Column& to, const Column& from, std::size_t n) {
    if (from.empty()) return;
    take_width(to, from);
    make_column(to, n);
  }
  template <class Column>
  static void make_column(Column& to, std::size_t n) {
    to.raw().reserve(kRoom * n * width_of(to));
    resize_column(to, n);
  }

  void place_vertices(int w) {
    const std::size_t n = verts_.size(), begin = share_begin(n, w, threads_), end = share_begin(n, w + 1, threads_);
    TetMesh& b = band_.mesh;
    for_each_vert_column(b, m_, [&](auto& to, const auto& from) {
      if (from.empty()) return;
      for (const VertId v : IdRange<VertId>(begin, end)) copy_entry(to, v, from, band_.to_rank[v]);
    });
    if (m_.metric.empty()) measure_metric(b, to_id<VertId>(begin), end - begin);
    // A tetrahedron outside has no vertex that is in near_, so whatever it shares with the band is frozen.
    for (const VertId v : IdRange<VertId>(begin, end)) {
      if (!near_.has(band_.to_rank[v])) b.vert_state[v] = (b.vert_state[v] & ~kActive) | kFrozen;
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
      band_.mesh.tet_class[to] = m_.tet_class[t];
    }
  }

  void cut_features() {
    for (const TetId t : band_.tets) {
      features_of(m_, t, [&](std::uint32_t place) {
        const FeatureEdge& e = m_.features.list()[place];
        const auto a = to_id<VertId>(verts_.place(e.a)), b = to_id<VertId>(verts_.place(e.b));
        if (band_.mesh.features.find(a, b) != nullptr) return;
        band_.mesh.features.insert({a, b, e.ref, e.edge_class});
        band_.features.push_back(e);
      });
    }
  }

  static constexpr std::size_t kRoom = 2;  ///< for so many times the vertices

  const TetMesh& m_;
  Surroundings near_;
  int threads_;
  Subset<TetId> tets_;
  Subset<VertId> verts_;
  Band band_;
};

/// Puts a band back into a mesh, or into what has one and more columns; the steps share the numbers of what comes in.
template <class Mesh>
class Return {
 public:
  Return(Mesh& all, const Band& band, int threads)
      : all_(all), m_(mesh_of(all)), band_(band), b_(band.mesh), threads_(threads) {}

  /// Gives the new numbers of vertices.
  MovedVerts run(const IdVector<VertId, VertId>& old2new) {
    for (const FeatureEdge& e : band_.features) m_.features.erase(e.a, e.b);
    place_vertices(old2new);
    place_tets();
    for (const FeatureEdge& e : b_.features.list()) m_.features.insert({vert_[e.a], vert_[e.b], e.ref, e.edge_class});
    fill_free_tets(m_, free_tets_);
    return fill_free_verts(all_, free_verts_, threads_);
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
    if (fresh > free_verts_.size()) resize_verts(all_, before + fresh - free_verts_.size());
    std::size_t next = 0, end = before;
    for (const VertId v : IdRange<VertId>(b_.vert_slots())) {
      if (vert_[v] != kNoVert) continue;
      vert_[v] = next < free_verts_.size() ? free_verts_[next++] : to_id<VertId>(end++);
      clear_entries(all_, vert_[v]);
      copy_entries(m_, vert_[v], b_, v);
    }
    free_verts_.erase(free_verts_.begin(), free_verts_.begin() + static_cast<std::ptrdiff_t>(next));
  }

  void keep_vertex(VertId v, VertId in_band) {
    vert_[in_band] = v;
    // What the band has only in part may be poor for the sake of the rest.
    const VertState told = b_.has(in_band, kActive) ? kBesideFrozen | kRetry : kRetry;
    m_.vert_state[v] = (m_.vert_state[v] & ~told) | (b_.vert_state[in_band] & (kBesideFrozen | kRetry));
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
      m_.tet_class[to] = b_.tet_class[t];
    }
  }

  /// Links the faces of the rest with those of the band. Faces of the band without a partner are on the interface
  /// between ranks.
  void close_seam(const std::vector<std::vector<FaceId>>& open) {
    std::vector<FaceId> sides = band_.seam;
    for (const auto& faces : open) sides.insert(sides.end(), faces.begin(), faces.end());
    link_equal_faces(m_, sides);
  }

  Mesh& all_;
  TetMesh& m_;
  const Band& band_;
  const TetMesh& b_;
  int threads_;
  IdVector<VertId, VertId> vert_;  ///< of the band -> of the rank
  IdVector<TetId, TetId> tet_;
  std::vector<VertId> free_verts_;  ///< ascending
  std::vector<TetId> free_tets_;
};

}  // namespace

Band cut_band(const TetMesh& mesh, Surroundings near, int threads) { return Cut(mesh, std::move(near), threads).run(); }

Band cut_band(const TetMesh& mesh, int layers, int threads) {
  std::vector<VertId> active;
  for (const VertId v : IdRange<VertId>(mesh.vert_slots())) {
    if (mesh.has(v, kActive)) active.push_back(v);
  }
  Surroundings near(mesh, std::move(active));
  for (int l = 0; l < layers; ++l) {
    near.add_tets();
    near.add_vertices();
  }
  return cut_band(mesh, std::move(near), threads);
}

void put_back(TetMesh& mesh, const Band& band, const IdVector<VertId, VertId>& old2new, std::span<VertId> kept,
              int threads) {
  SKEIN_ASSERT_NO_FAULT_AT(2, check_sizes(band.mesh));
  const MovedVerts now = Return(mesh, band, threads).run(old2new);
  for (VertId& v : kept) v = now(v);
}

void put_back(DistMesh& dist, const Band& band, const IdVector<VertId, VertId>& old2new, int threads) {
  SKEIN_ASSERT_NO_FAULT_AT(2, check_sizes(band.mesh));
  const MovedVerts now = Return(dist, band, threads).run(old2new);
  for (VertId& v : dist.sharing.vert) v = now(v);
}

}  // namespace skein
