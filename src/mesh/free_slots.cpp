// Moving what lies at the end of the arrays into their gaps.
#include "mesh/free_slots.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "base/hash.hpp"
#include "base/parallel.hpp"

namespace skein {
namespace {

template <class Vector>
void resize(Vector& v, std::size_t n) {
  reserve_with_slack(v, n);
  v.resize(n);
}

void move_tet(TetMesh& m, TetId from, TetId to) {
  m.tet2vert[to] = m.tet2vert[from];
  m.tet2face[to] = m.tet2face[from];
  m.face_tag[to] = m.face_tag[from];
  m.tet_ref[to] = m.tet_ref[from];
  m.tet_class[to] = m.tet_class[from];
  for (const VertId v : m.tet2vert[to]) m.vert2tet[v] = to;
  for (std::size_t k = 0; k < 4; ++k) {
    const FaceId f = m.tet2face[to][k];
    if (f != kNoFace) m.link(f, make_face(to, k));
  }
}

}  // namespace

namespace {

/// Faces by their vertices: open addressing, at most half full.
class FaceTable {
 public:
  explicit FaceTable(std::size_t n) : sides_(std::bit_ceil(2 * n + 1)) {}
  /// The place of a face with these vertices, or the free one where it would be.
  FaceId& at(const TetMesh& m, FaceId f) noexcept {
    auto v = m.verts(f);
    std::sort(v.begin(), v.end());
    const std::int64_t low = std::int64_t{num(v[0])} << 32 | num(v[1]);
    const auto key = static_cast<std::uint64_t>(low) + static_cast<std::uint64_t>(num(v[2])) * 0xbf58476d1ce4e5b9U;
    const std::size_t mask = sides_.size() - 1;
    std::size_t s = table_hash(key) & mask;
    while (sides_[s].face != kNoFace && (sides_[s].low != low || sides_[s].high != v[2])) s = (s + 1) & mask;
    sides_[s].low = low;
    sides_[s].high = v[2];
    return sides_[s].face;
  }

 private:
  struct Side {
    std::int64_t low = -1;  ///< the two vertices with the lowest numbers in one
    VertId high = kNoVert;
    FaceId face = kNoFace;
  };
  std::vector<Side> sides_;
};

}  // namespace

void link_equal_faces(TetMesh& m, std::span<const FaceId> faces, std::span<const FaceId> others) {
  FaceTable table(faces.size());
  for (const FaceId f : faces) {
    FaceId& place = table.at(m, f);
    if (place == kNoFace) {
      place = f;
    } else {
      m.link(place, f);  // what is linked stays, as others may have been pushed on by it
    }
  }
  for (const FaceId f : others) {
    const FaceId g = table.at(m, f);
    if (g != kNoFace) m.link(f, g);
  }
}

void resize_tets(TetMesh& m, std::size_t n) {
  resize(m.tet2vert, n);
  resize(m.tet2face, n);
  resize(m.face_tag, n);
  resize(m.tet_ref, n);
  resize(m.tet_class, n);
}

void resize_vert2tet(TetMesh& m, std::size_t n) {
  reserve_with_slack(m.vert2tet, n);
  m.vert2tet.resize(n, kNoTet);
}

void grow_verts(TetMesh& m, std::size_t n, int threads) {
  std::apply(
      [&](auto... c) {
        const auto size = [&](const auto& column) { return column.empty() ? 0 : n * width_of(column); };
        grow_in_parallel(threads, std::tie((m.*c).raw()..., m.vert2tet.raw()), {size(m.*c)..., n});
      },
      kVertColumns);
}

void fill_free_tets(TetMesh& m, const std::vector<TetId>& free) {
  resize_tets(m, fill_free_slots(free, m.tet_slots(), [&](TetId from, TetId to) { move_tet(m, from, to); }));
}

void follow(TetMesh& m, const MovedVerts& now, int threads) {
  const std::size_t n = m.tet_slots();
  in_parallel(threads, [&](int w) {
    for (const TetId t : IdRange<TetId>(share_begin(n, w, threads), share_begin(n, w + 1, threads))) {
      for (auto& v : m.tet2vert[t]) {
        if (now.moves(v)) v = now(v);
      }
    }
  });
  const std::vector<FeatureEdge> edges = m.features.list();
  for (const FeatureEdge& e : edges) {
    if (!now.moves(e.a) && !now.moves(e.b)) continue;
    m.features.erase(e.a, e.b);
    m.features.insert({now(e.a), now(e.b), e.ref, e.edge_class});
  }
}

}  // namespace skein
