// Joining blocks.
#include <algorithm>
#include <array>
#include <tuple>

#include "adapt/blocks.hpp"
#include "adapt/gaps.hpp"
#include "base/assert.hpp"
#include "base/parallel.hpp"
#include "base/subset.hpp"
#include "mesh/check.hpp"
#include "mesh/free_slots.hpp"

namespace skein {

void seal_block(Block& block, const IdVector<VertId, VertId>& old2new) {
  Part& p = block.part;
  p.q3 = {};
  p.tet_mark = {};
  p.refused = {};
  p.dirty = {};
  p.edges = {};
  p.vert_mark = {};
  p.edge_class = {};
  IdVector<VertId, VertId> up;
  const bool few = are_few(p.free_tets.size(), p.mesh.tet_slots());
  if (few) {
    p.free_tets = ascending(p.free_tets, p.mesh.tet_slots());
    p.free_verts = ascending(p.free_verts, p.mesh.vert_slots());
  } else {
    up = close_gaps(p.mesh);
    p.free_tets.clear();
    p.free_verts.clear();
  }
  block.tets = Moved<TetId>(p.mesh.tet_slots() - p.free_tets.size(), p.free_tets.size());
  fill_free_slots(p.free_tets, p.mesh.tet_slots(), [&](TetId from, TetId to) { block.tets.set(from, to); });
  const auto now = [&](VertId v) { return few ? old2new[v] : up[old2new[v]]; };
  block.common_id.clear();
  for (VertId& v : block.common) {
    block.common_id.push_back(block.id[v]);
    v = now(v);
  }
  for (VertId& v : block.frozen) v = now(v);
  block.id = {};
}

namespace {

/// Where what is added to an array goes: first into its free slots.
template <Identifier Id>
class Places {
 public:
  Places() = default;
  Places(std::vector<Id> free, std::size_t slots) : free_(std::move(free)), slots_(slots) {}
  [[nodiscard]] Id operator()(std::size_t i) const noexcept {
    return i < free_.size() ? free_[i] : to_id<Id>(slots_ + i - free_.size());
  }
  [[nodiscard]] const std::vector<Id>& free() const noexcept { return free_; }
  [[nodiscard]] std::size_t slots() const noexcept { return slots_; }
  /// The slots when n are added, of which some may still be free.
  [[nodiscard]] std::size_t slots_with(std::size_t n) const noexcept {
    return slots_ + (n > free_.size() ? n - free_.size() : 0);
  }

 private:
  std::vector<Id> free_;
  std::size_t slots_ = 0;
};

/// Steps over the items of an ascending list, as long as it is asked for ascending ids.
template <Identifier Id>
class Skip {
 public:
  Skip(const std::vector<Id>& list, Id first)
      : at_(std::lower_bound(list.begin(), list.end(), first)), end_(list.end()) {}
  [[nodiscard]] bool operator()(Id i) noexcept {
    const bool found = at_ != end_ && *at_ == i;
    if (found) ++at_;
    return found;
  }

 private:
  typename std::vector<Id>::const_iterator at_, end_;
};

/// Gives the blocks' vertices and tetrahedra numbers behind one another and brings them there.
class Joiner {
 public:
  Joiner(std::vector<Block>& blocks, std::size_t old_verts)
      : blocks_(blocks), threads_(static_cast<int>(blocks.size())), pieces_(blocks.size()) {
    out_.old2new.assign(old_verts, kNoVert);
  }

  Merged run() {
    find_twins();
    count();
    thaw();
    note_frozen_and_features();
    for (const Piece& p : pieces_) {
      for (const Twin& twin : p.twins) out_.between.push_back(number(twin.of_block, twin.of));
    }
    std::sort(out_.between.begin(), out_.between.end());
    out_.between.erase(std::unique(out_.between.begin(), out_.between.end()), out_.between.end());
    make_room();
    in_parallel(threads_, [&](int w) { place_vertices(w); });
    for (const Piece& p : pieces_) {
      for (const Twin& twin : p.twins) join_twin(twin);
    }
    std::vector<std::vector<FaceId>> open(blocks_.size());
    in_parallel(threads_, [&](int w) { place_tets(w, open[w]); });
    blocks_.clear();
    match_faces(open);
    close_what_is_left();
    return std::move(out_);
  }

 private:
  /// A vertex of a block that an earlier block has, too, and where it is there.
  struct Twin {
    VertId v;
    std::size_t of_block;
    VertId of;
    VertClass of_class;
    VertState state;
  };
  struct Piece {
    std::vector<Twin> twins;                    ///< ascending
    std::vector<VertId> gone;                   ///< twins and free ones, ascending
    std::size_t first_vert = 0, first_tet = 0;  ///< in the order of what is added to the first block
    IdVector<VertId, VertId> new_of;
  };

  void find_twins() {
    struct Common {
      GlobalId id;
      std::size_t block;
      VertId v;
    };
    std::vector<Common> all;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      for (std::size_t i = 0; i < blocks_[b].common.size(); ++i) {
        all.push_back({blocks_[b].common_id[i], b, blocks_[b].common[i]});
      }
    }
    std::sort(all.begin(), all.end(),
              [](const Common& a, const Common& b) { return a.id != b.id ? a.id < b.id : a.block < b.block; });
    for (std::size_t i = 0, first = 0; i < all.size(); ++i) {
      if (all[i].id != all[first].id) first = i;
      if (i != first) pieces_[all[i].block].twins.push_back({all[i].v, all[first].block, all[first].v, {}, {}});
    }
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      auto& twins = pieces_[b].twins;
      std::sort(twins.begin(), twins.end(), [](const Twin& x, const Twin& y) { return x.v < y.v; });
      for (Twin& twin : twins) {
        const TetMesh& m = blocks_[b].part.mesh;
        twin.of_class = m.vert_class[twin.v];
        twin.state = m.vert_state[twin.v] & ~kFrozen;
      }
    }
  }

  void count() {
    std::size_t verts = 0, tets = 0;
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      const Part& part = blocks_[b].part;
      Piece& p = pieces_[b];
      p.gone = part.free_verts;
      for (const Twin& twin : p.twins) p.gone.push_back(twin.v);
      std::inplace_merge(p.gone.begin(), p.gone.begin() + std::ssize(part.free_verts), p.gone.end());
      p.first_vert = verts, p.first_tet = tets;
      verts += part.mesh.vert_slots() - p.gone.size();
      tets += part.mesh.tet_slots() - part.free_tets.size();
    }
    added_verts_ = verts, added_tets_ = tets;
    Part& first = blocks_[0].part;
    vert_places_ = {std::move(first.free_verts), first.mesh.vert_slots()};
    tet_places_ = {std::move(first.free_tets), first.mesh.tet_slots()};
  }

  [[nodiscard]] std::size_t gone_below(std::size_t b, VertId v) const {
    const auto& gone = pieces_[b].gone;
    return static_cast<std::size_t>(std::lower_bound(gone.begin(), gone.end(), v) - gone.begin());
  }
  /// What becomes of vertex v of block b.
  [[nodiscard]] VertId number(std::size_t b, VertId v) const {
    if (b == 0) return v;
    const auto& twins = pieces_[b].twins;
    const auto at = std::lower_bound(twins.begin(), twins.end(), v, [](const Twin& x, VertId y) { return x.v < y; });
    if (at != twins.end() && at->v == v) return number(at->of_block, at->of);
    return vert_places_(pieces_[b].first_vert + idx(v) - gone_below(b, v));
  }
  /// What becomes of tetrahedron t of block b, not the first one.
  [[nodiscard]] TetId number(std::size_t b, TetId t) const noexcept {
    return tet_places_(pieces_[b].first_tet + idx(blocks_[b].tets(t)));
  }

  /// Frozen is now what was frozen before the cut.
  void thaw() {
    for (Block& b : blocks_) {
      auto& state = b.part.mesh.vert_state;
      for (const VertId v : b.common) state[v] &= ~kFrozen;
      for (const VertId v : b.frozen) state[v] |= kFrozen;
    }
  }

  void note_frozen_and_features() {
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const Block& block = blocks_[b];
      for (std::size_t i = 0; i < block.frozen.size(); ++i) {
        out_.old2new[block.frozen_of[i]] = number(b, block.frozen[i]);
      }
      if (b == 0) continue;
      for (const FeatureEdge& e : block.part.mesh.features.list()) {
        blocks_[0].part.mesh.features.insert({number(b, e.a), number(b, e.b), e.ref, e.edge_class});
      }
    }
  }

  void make_room() {
    const std::size_t nt = tet_places_.slots_with(added_tets_), nv = vert_places_.slots_with(added_verts_);
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      pieces_[b].new_of.resize(blocks_[b].part.mesh.vert_slots());
      for (const Twin& twin : pieces_[b].twins) pieces_[b].new_of[twin.v] = number(twin.of_block, twin.of);
    }
    out_.mesh = std::move(blocks_[0].part.mesh);
    TetMesh& m = out_.mesh;
    grow_in_parallel(threads_,
                     std::tie(m.tet2vert.raw(), m.tet2face.raw(), m.face_tag.raw(), m.tet_ref.raw(), m.tet_class.raw()),
                     nt);
    grow_verts(m, nv, threads_);
  }

  /// Thread w's share of the vertices of every block but the first.
  void place_vertices(int w) {
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      const TetMesh& m = blocks_[b].part.mesh;
      Piece& p = pieces_[b];
      const std::size_t n = m.vert_slots(), end = share_begin(n, w + 1, threads_);
      const auto begin = to_id<VertId>(share_begin(n, w, threads_));
      Skip gone(p.gone, begin);
      std::size_t at = p.first_vert + idx(begin) - gone_below(b, begin);
      for (const VertId v : IdRange<VertId>(idx(begin), end)) {
        if (gone(v)) continue;
        const VertId to = p.new_of[v] = vert_places_(at++);
        copy_entries(out_.mesh, to, m, v);
        out_.mesh.vert2tet[to] = number(b, m.vert2tet[v]);
      }
    }
  }

  /// A block may have the middle of an edge's shell only and not know that a new vertex on it is on the surface.
  void join_twin(const Twin& twin) {
    const VertId v = number(twin.of_block, twin.of);
    out_.mesh.vert_class[v] |= twin.of_class;
    out_.mesh.vert_state[v] |= twin.state;
  }

  /// Thread w's share of the tetrahedra of every block. `open`: faces between parts.
  void place_tets(int w, std::vector<FaceId>& open) {
    const auto look = [&](TetId t) {
      for (std::size_t i = 0; i < 4; ++i) {
        if (out_.mesh.tet2face[t][i] != kNoFace || is_hull(out_.mesh.face_tag[t][i])) continue;
        open.push_back(make_face(t, i));
      }
    };
    const auto share = [&](std::size_t n) {
      return IdRange<TetId>(share_begin(n, w, threads_), share_begin(n, w + 1, threads_));
    };
    const auto first = share(tet_places_.slots());
    Skip free(tet_places_.free(), *first.begin());
    for (const TetId t : first) {
      if (!free(t)) look(t);
    }
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      const TetMesh& m = blocks_[b].part.mesh;
      const Piece& p = pieces_[b];
      for (const TetId t : share(m.tet_slots())) {
        if (!m.is_live(t)) continue;
        const TetId to = number(b, t);
        for (std::size_t i = 0; i < 4; ++i) {
          out_.mesh.tet2vert[to][i] = p.new_of[m.tet2vert[t][i]];
          const FaceId f = m.tet2face[t][i];
          out_.mesh.tet2face[to][i] = f == kNoFace ? kNoFace : make_face(number(b, face_tet(f)), face_side(f));
        }
        out_.mesh.face_tag[to] = m.face_tag[t];
        out_.mesh.tet_ref[to] = m.tet_ref[t];
        out_.mesh.tet_class[to] = m.tet_class[t];
        look(to);
      }
    }
  }

  void match_faces(const std::vector<std::vector<FaceId>>& open) {
    std::vector<FaceId> all;
    for (const auto& faces : open) all.insert(all.end(), faces.begin(), faces.end());
    link_equal_faces(out_.mesh, all);
  }

  /// The first block may have more free slots than the others have items.
  void close_what_is_left() {
    if (added_tets_ >= tet_places_.free().size() && added_verts_ >= vert_places_.free().size()) return;
    const auto now = close_gaps(out_.mesh);
    for (VertId& v : out_.between) v = now[v];
    std::sort(out_.between.begin(), out_.between.end());
    for (VertId& v : out_.old2new) {
      if (v != kNoVert) v = now[v];
    }
  }

  std::vector<Block>& blocks_;
  int threads_;
  std::vector<Piece> pieces_;
  Places<VertId> vert_places_;
  Places<TetId> tet_places_;
  std::size_t added_verts_ = 0, added_tets_ = 0;
  Merged out_;
};

}  // namespace

Merged merge_blocks(std::vector<Block>& blocks, std::size_t old_verts) {
  for ([[maybe_unused]] const Block& b : blocks) SKEIN_ASSERT_NO_FAULT_AT(2, check_sizes(b.part.mesh));
  return Joiner(blocks, old_verts).run();
}

}  // namespace skein
