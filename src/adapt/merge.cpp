// Joining blocks.
#include <algorithm>
#include <array>
#include <tuple>

#include "adapt/blocks.hpp"
#include "adapt/gaps.hpp"
#include "mesh/holes.hpp"
#include "mesh/parallel.hpp"

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
  const auto step = close_gaps(p.mesh, p.metric);
  block.common_id.clear();
  for (VertId& v : block.common) {
    block.common_id.push_back(block.id[v]);
    v = step[old2new[v]];
  }
  for (VertId& v : block.frozen) v = step[old2new[v]];
  block.id = {};
}

namespace {

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
      // A block may have the middle of an edge's shell only and not know that a new vertex on it is on the surface.
      for (const Twin& twin : p.twins) out_.mesh.vert_flags[number(twin.of_block, twin.of)] |= twin.flags;
    }
    std::vector<std::vector<FaceId>> open(blocks_.size());
    in_parallel(threads_, [&](int w) { place_tets(w, open[static_cast<std::size_t>(w)]); });
    blocks_.clear();
    match_faces(open);
    return std::move(out_);
  }

 private:
  /// A vertex of a block that an earlier block has, too, and where it is there.
  struct Twin {
    VertId v;
    std::size_t of_block;
    VertId of;
    std::uint8_t flags;
  };
  struct Piece {
    std::vector<Twin> twins;  ///< ascending
    std::size_t first_vert = 0, first_tet = 0;
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
      if (i != first) pieces_[all[i].block].twins.push_back({all[i].v, all[first].block, all[first].v, 0});
    }
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      auto& twins = pieces_[b].twins;
      std::sort(twins.begin(), twins.end(), [](const Twin& x, const Twin& y) { return x.v < y.v; });
      for (Twin& twin : twins) {
        twin.flags = static_cast<std::uint8_t>(blocks_[b].part.mesh.vert_flags[twin.v] & ~(kWasFrozen | kFrozen));
      }
    }
  }

  void count() {
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      const TetMesh& before = blocks_[b - 1].part.mesh;
      pieces_[b].first_vert = pieces_[b - 1].first_vert + before.vert_slots() - pieces_[b - 1].twins.size();
      pieces_[b].first_tet = pieces_[b - 1].first_tet + before.tet_slots();
    }
  }

  /// Twins of the block with numbers below v.
  [[nodiscard]] std::size_t twins_below(std::size_t b, VertId v) const {
    const auto& twins = pieces_[b].twins;
    const auto at = std::lower_bound(twins.begin(), twins.end(), v, [](const Twin& x, VertId y) { return x.v < y; });
    return static_cast<std::size_t>(at - twins.begin());
  }
  /// What becomes of vertex v of block b.
  [[nodiscard]] VertId number(std::size_t b, VertId v) const {
    const auto& twins = pieces_[b].twins;
    const std::size_t below = twins_below(b, v);
    if (below < twins.size() && twins[below].v == v) return number(twins[below].of_block, twins[below].of);
    return to_id<VertId>(pieces_[b].first_vert + idx(v) - below);
  }

  /// Frozen is now what was frozen before the cut.
  void thaw() {
    for (Block& b : blocks_) {
      auto& flags = b.part.mesh.vert_flags;
      for (const VertId v : b.common) {
        if ((flags[v] & kWasFrozen) == 0) flags[v] = static_cast<std::uint8_t>(flags[v] & ~kFrozen);
      }
      for (const VertId v : b.frozen) flags[v] = static_cast<std::uint8_t>(flags[v] & ~kWasFrozen);
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
        blocks_[0].part.mesh.features.insert(number(b, e.a), number(b, e.b), e.ref, e.ridge);
      }
    }
  }

  void make_room() {
    const TetMesh& last = blocks_.back().part.mesh;
    const std::size_t nt = pieces_.back().first_tet + last.tet_slots(),
                      nv = pieces_.back().first_vert + last.vert_slots() - pieces_.back().twins.size();
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      pieces_[b].new_of.resize(b == 0 ? 0 : blocks_[b].part.mesh.vert_slots());
    first_tets_ = blocks_[0].part.mesh.tet_slots();
    out_.mesh = std::move(blocks_[0].part.mesh);
    out_.metric = std::move(blocks_[0].part.metric);
    TetMesh& m = out_.mesh;
    grow_in_parallel(threads_, std::tie(m.tet2vert.raw(), m.tet2face.raw(), m.face_tag.raw(), m.tet_ref.raw()), nt);
    grow_in_parallel(threads_,
                     std::tie(out_.metric.at.raw(), out_.metric.log_at.raw(), m.coords.raw(), m.vert2tet.raw(),
                              m.vert_ref.raw(), m.vert_flags.raw()),
                     nv);
  }

  /// Thread w's share of the vertices of every block but the first.
  void place_vertices(int w) {
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      const TetMesh& m = blocks_[b].part.mesh;
      const MetricField& metric = blocks_[b].part.metric;
      Piece& p = pieces_[b];
      const std::size_t n = m.vert_slots(), end = share_begin(n, w + 1, threads_);
      const auto begin = to_id<VertId>(share_begin(n, w, threads_));
      auto twin = p.twins.begin() + static_cast<std::ptrdiff_t>(twins_below(b, begin));
      for (std::size_t i = idx(begin); i < end; ++i) {
        const auto v = to_id<VertId>(i);
        if (twin != p.twins.end() && twin->v == v) {
          p.new_of[v] = number(twin->of_block, twin->of);
          ++twin;
          continue;
        }
        const auto to = to_id<VertId>(p.first_vert + i - static_cast<std::size_t>(twin - p.twins.begin()));
        p.new_of[v] = to;
        out_.mesh.coords[to] = m.coords[v];
        out_.mesh.vert_ref[to] = m.vert_ref[v];
        out_.mesh.vert_flags[to] = m.vert_flags[v];
        out_.mesh.vert2tet[to] = to_id<TetId>(idx(m.vert2tet[v]) + p.first_tet);
        out_.metric.at[to] = metric.at[v];
        out_.metric.log_at[to] = metric.log_at[v];
      }
    }
  }

  /// Thread w's share of the tetrahedra of every block. `open`: faces between parts.
  void place_tets(int w, std::vector<FaceId>& open) {
    const auto look = [&](TetId t) {
      for (std::size_t i = 0; i < 4; ++i) {
        if (out_.mesh.tet2face[t][i] != kNoFace || is_hull(out_.mesh.face_tag[t][i])) continue;
        open.push_back(make_face(t, static_cast<int>(i)));
      }
    };
    const auto share = [&](std::size_t n, std::size_t first) {
      const std::size_t begin = share_begin(n, w, threads_);
      return IdRange<TetId>(first + begin, first + share_begin(n, w + 1, threads_));
    };
    for (const TetId t : share(first_tets_, 0)) look(t);
    for (std::size_t b = 1; b < blocks_.size(); ++b) {
      const TetMesh& m = blocks_[b].part.mesh;
      const Piece& p = pieces_[b];
      for (const TetId to : share(m.tet_slots(), p.first_tet)) {
        const auto t = to_id<TetId>(idx(to) - p.first_tet);
        for (std::size_t i = 0; i < 4; ++i) {
          out_.mesh.tet2vert[to][i] = p.new_of[m.tet2vert[t][i]];
          const FaceId f = m.tet2face[t][i];
          out_.mesh.tet2face[to][i] = f == kNoFace ? kNoFace : to_id<FaceId>(idx(f) + 4 * p.first_tet);
        }
        out_.mesh.face_tag[to] = m.face_tag[t];
        out_.mesh.tet_ref[to] = m.tet_ref[t];
        look(to);
      }
    }
  }

  void match_faces(const std::vector<std::vector<FaceId>>& open) {
    std::vector<FaceId> all;
    for (const auto& faces : open) all.insert(all.end(), faces.begin(), faces.end());
    link_equal_faces(out_.mesh, all);
  }

  std::vector<Block>& blocks_;
  int threads_;
  std::vector<Piece> pieces_;
  std::size_t first_tets_ = 0;  ///< of the first block
  Merged out_;
};

}  // namespace

Merged merge_blocks(std::vector<Block>& blocks, std::size_t old_verts) { return Joiner(blocks, old_verts).run(); }

}  // namespace skein
