// Migration in three steps: pack what leaves, find what it leaves behind, put what comes in its place.
#include "dist/migrate.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/assert.hpp"
#include "base/error.hpp"
#include "base/subset.hpp"
#include "dist/column_pack.hpp"
#include "dist/feature_scan.hpp"
#include "dist/partition.hpp"
#include "dist/rendezvous.hpp"
#include "dist/sharing.hpp"
#include "mesh/check.hpp"
#include "mesh/free_slots.hpp"
#include "mesh/surroundings.hpp"

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
  TetClass tet_class;
  std::array<std::uint8_t, 3> unused;
};
struct MovedVert {
  GlobalId gid;
  std::int64_t shared;
};
struct MovedFeature {
  std::int32_t a, b, ref, edge_class;
};
struct Load {
  Packets<MovedTet> tets;
  Packets<MovedVert> verts;
  Packets<std::byte> columns;  ///< the vertices' entries, as ColumnLayout says
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
  std::vector<std::size_t> offset;   ///< by rank
  Subset<TetId> set;                 ///< all of them
  std::vector<std::uint32_t> place;  ///< in `tets`, by their places in the set

  [[nodiscard]] bool none() const noexcept { return tets.empty(); }
  [[nodiscard]] bool has(TetId t) const noexcept { return set.has(t); }
  /// Its place among those that go to r, or -1.
  [[nodiscard]] std::int32_t place_to(TetId t, Rank r) const noexcept {
    if (!set.has(t)) return -1;
    const std::size_t at = place[set.place(t)];
    return at >= offset[idx(r)] && at < offset[idx(r) + 1] ? static_cast<std::int32_t>(at - offset[idx(r)]) : -1;
  }
};

Leaving sort_out(const Comm& comm, const Moves& moves, std::size_t n_tets) {
  Leaving l{{}, std::vector<std::size_t>(static_cast<std::size_t>(comm.size()) + 1, 0), Subset<TetId>(n_tets), {}};
  for (std::size_t i = 0; i < moves.tets.size(); ++i) {
    if (moves.to[i] == comm.rank()) continue;
    ++l.offset[idx(moves.to[i]) + 1];
    l.set.insert(moves.tets[i]);
  }
  for (std::size_t r = 1; r < l.offset.size(); ++r) l.offset[r] += l.offset[r - 1];
  l.set.number();
  l.tets.resize(l.offset.back());
  l.place.resize(l.offset.back());
  std::vector<std::size_t> next(l.offset.begin(), l.offset.end() - 1);
  for (std::size_t i = 0; i < moves.tets.size(); ++i) {
    if (moves.to[i] == comm.rank()) continue;
    const TetId t = moves.tets[i];
    const std::size_t at = next[idx(moves.to[i])]++;
    l.place[l.set.place(t)] = static_cast<std::uint32_t>(at);
    l.tets[at] = t;
  }
  return l;
}

/// The feature edges (as places in the list) that are edges of tetrahedra going to each rank; sorted, each once.
using FeatureUse = std::pair<Rank, std::uint32_t>;
std::vector<FeatureUse> features_by_rank(const TetMesh& m, const Leaving& leaving) {
  std::vector<FeatureUse> use;
  for (std::size_t r = 0; r + 1 < leaving.offset.size() && m.features.size() != 0; ++r) {
    for (std::size_t i = leaving.offset[r]; i < leaving.offset[r + 1]; ++i) {
      features_of(m, leaving.tets[i], [&](std::uint32_t edge) { use.emplace_back(to_id<Rank>(r), edge); });
    }
  }
  std::sort(use.begin(), use.end());
  use.erase(std::unique(use.begin(), use.end()), use.end());
  return use;
}

class Packer {
 public:
  Packer(const DistMesh& dist, const ColumnLayout& layout, const Leaving& leaving,
         const std::vector<FeatureUse>& features)
      : dist_(dist), layout_(layout), leaving_(leaving), features_(features) {
    if (leaving.none()) return;
    shared_.assign(dist.mesh.vert_slots(), 0);
    for (const VertId v : dist.sharing.vert) shared_[v] = 1;
    number_.assign(dist.mesh.vert_slots(), -1);
  }
  Load pack() {
    load_.tets.items.reserve(leaving_.tets.size());
    for (std::size_t r = 0; r + 1 < leaving_.offset.size(); ++r) {
      if (leaving_.offset[r + 1] > leaving_.offset[r]) pack_tets(to_id<Rank>(r));
    }
    load_.verts.items.reserve(used_.size());
    for (const VertId v : used_) load_.verts.items.push_back({dist_.vert2gid[v], shared_[v]});
    load_.columns.items = pack_columns(dist_.mesh, layout_, used_);
    load_.columns.rank = load_.verts.rank;
    for (std::size_t b = 1; b < load_.verts.offset.size(); ++b)
      load_.columns.offset.push_back(load_.verts.offset[b] * layout_.bytes);
    return std::move(load_);
  }

 private:
  /// Tetrahedra, vertices' numbers and features that go to r.
  void pack_tets(Rank r) {
    const std::vector<FeatureEdge>& edges = dist_.mesh.features.list();
    first_ = used_.size();
    for (std::size_t i = leaving_.offset[idx(r)]; i < leaving_.offset[idx(r) + 1]; ++i) pack_tet(leaving_.tets[i], r);
    close_block(load_.tets, r);
    load_.verts.rank.push_back(r);
    load_.verts.offset.push_back(used_.size());
    auto it = std::lower_bound(features_.begin(), features_.end(), FeatureUse{r, 0});
    for (; it != features_.end() && it->first == r; ++it) {
      const FeatureEdge& e = edges[it->second];
      load_.features.items.push_back({number_[e.a], number_[e.b], e.ref, static_cast<std::int32_t>(e.edge_class)});
    }
    close_block(load_.features, r);
    for (std::size_t k = first_; k < used_.size(); ++k) number_[used_[k]] = -1;
  }
  void pack_tet(TetId t, Rank r) {
    const TetMesh& m = dist_.mesh;
    MovedTet out{};
    for (std::size_t k = 0; k < 4; ++k) {
      const VertId v = m.tet2vert[t][k];
      if (number_[v] < 0) {
        number_[v] = static_cast<std::int32_t>(used_.size() - first_);
        used_.push_back(v);
      }
      out.vert[k] = number_[v];
      const FaceId f = m.tet2face[t][k];
      if (f == kNoFace) {
        out.face[k] = is_hull(m.face_tag[t][k]) ? kOpen : kWasInterface;
      } else {
        const std::int32_t at = leaving_.place_to(face_tet(f), r);
        out.face[k] = at >= 0 ? 4 * at + face_side(f) : kOpen;
      }
    }
    out.tag = m.face_tag[t];
    out.ref = m.tet_ref[t];
    out.tet_class = m.tet_class[t];
    load_.tets.items.push_back(out);
  }

  const DistMesh& dist_;
  const ColumnLayout& layout_;
  const Leaving& leaving_;
  const std::vector<FeatureUse>& features_;
  IdVector<VertId, char> shared_;
  IdVector<VertId, std::int32_t> number_;  ///< in the current block
  std::vector<VertId> used_;               ///< of all blocks, in order
  std::size_t first_ = 0;                  ///< of the current block
  Load load_;
};

/// What stays, as far as it may meet what comes or has lost neighbours.
struct Staying {
  std::vector<VertId> verts;  ///< at what leaves, or shared before
  std::vector<FaceId> open;   ///< on the interface before
  std::vector<VertId> gone;   ///< vertices that have no tetrahedra any more; ascending
  std::vector<FeatureEdge> gone_features;
};

/// Finds these round what leaves, and gives the vertices there a tetrahedron that stays. What was shared and has
/// nothing that leaves beside it stays as it is.
class Stayers {
 public:
  Stayers(DistMesh& dist, const Leaving& leaving, const std::vector<FeatureUse>& features)
      : m_(dist.mesh), leaving_(leaving), state_(dist.mesh.vert_slots(), 0), feature_state_(m_.features.size(), 0) {
    for (const TetId t : leaving.tets) {
      for (const VertId v : m_.tet2vert[t]) {
        if (state_[v] == 0) touched_.push_back(v);
        state_[v] = kTouched;
      }
    }
    for (const VertId v : dist.sharing.vert) {
      if (state_[v] == 0) out_.verts.push_back(v);
    }
    for (const auto& [rank, edge] : features) feature_state_[edge] = kTouched;
  }

  /// `open`: the tetrahedra with a face without a neighbour, if they are known.
  Staying find(const std::vector<FeatureUse>& features, const std::optional<std::vector<TetId>>& open) {
    // The tetrahedra at a vertex or an edge hang together over faces, so that one that stays is a neighbour of one that
    // leaves, or they do not, and then those that stay have a face without a neighbour there.
    for (const TetId t : leaving_.tets) {
      for (const FaceId f : m_.tet2face[t]) {
        if (f != kNoFace && !leaving_.has(face_tet(f))) look_at(face_tet(f), !features.empty());
      }
    }
    const auto look = [&](TetId t) {
      if (!leaving_.has(t)) look_at_open(t, !features.empty());
    };
    if (open.has_value()) {
      std::for_each(open->begin(), open->end(), look);
    } else {
      visit_open_tets(m_, look);
    }
    for (const VertId v : touched_) (state_[v] == kStays ? out_.verts : out_.gone).push_back(v);
    std::sort(out_.gone.begin(), out_.gone.end());
    const auto gone = [&](VertId v) { return state_[v] == kTouched; };
    for (std::size_t i = 0; i < feature_state_.size(); ++i) {
      const FeatureEdge& e = m_.features.list()[i];
      if (feature_state_[i] == kTouched || gone(e.a) || gone(e.b)) out_.gone_features.push_back(e);
    }
    return std::move(out_);
  }

 private:
  static constexpr char kTouched = 1, kStays = 2;

  void look_at(TetId t, bool features) {
    for (std::size_t k = 0; k < 4; ++k) {
      const VertId v = m_.tet2vert[t][k];
      if (state_[v] == 0) continue;
      state_[v] = kStays;
      m_.vert2tet[v] = t;
    }
    if (features) {
      features_of(m_, t, [&](std::uint32_t edge) { feature_state_[edge] = feature_state_[edge] != 0 ? kStays : 0; });
    }
  }

  void look_at_open(TetId t, bool features) {
    look_at(t, features);
    for (std::size_t k = 0; k < 4; ++k) {
      if (m_.tet2face[t][k] == kNoFace && !is_hull(m_.face_tag[t][k])) out_.open.push_back(make_face(t, k));
    }
  }

  TetMesh& m_;
  const Leaving& leaving_;
  IdVector<VertId, char> state_;
  std::vector<char> feature_state_;
  std::vector<VertId> touched_;
  Staying out_;
};

/// Puts what comes into the places of what has gone; the steps share the numbers of what comes.
class Arrival {
 public:
  Arrival(DistMesh& dist, const ColumnLayout& layout, const Load& load, const Leaving& leaving, Staying staying)
      : dist_(dist),
        m_(dist.mesh),
        layout_(layout),
        load_(load),
        staying_(std::move(staying)),
        free_tets_(ascending(leaving.tets, dist.mesh.tet_slots())) {}

  /// Gives the vertices that may be shared now.
  std::vector<VertId> run() {
    unlink_gone();
    number_vertices();
    std::vector<FaceId> open;
    put_tets(open);
    link_equal_faces(m_, open, staying_.open);
    fill_free_tets(m_, free_tets_);
    const MovedVerts now = fill_free_verts(dist_, staying_.gone);
    std::vector<VertId> met = std::move(staying_.verts);
    met.insert(met.end(), fresh_.begin(), fresh_.end());
    for (VertId& v : met) v = now(v);
    return met;
  }

 private:
  void unlink_gone() {
    for (const TetId t : free_tets_) {
      for (const FaceId f : m_.tet2face[t]) {
        if (f != kNoFace) m_.neighbour(f) = kNoFace;
      }
    }
    for (const FeatureEdge& e : staying_.gone_features) m_.features.erase(e.a, e.b);
  }

  /// Those that are here already by their global id, the others in order.
  void number_vertices() {
    std::vector<VertId> here;  // of shared ones, by the numbers of `shared`
    GidMap shared(dist_.sharing.size() + load_.verts.items.size());
    for (const VertId v : staying_.verts) {
      if (shared.insert(dist_.vert2gid[v]) == to_id<VertId>(here.size())) here.push_back(v);
    }
    auto& gone = staying_.gone;
    std::size_t taken = 0, end = m_.vert_slots();
    vert_.reserve(load_.verts.items.size());
    for (const MovedVert& in : load_.verts.items) {
      std::size_t at = here.size();
      if (in.shared != 0) at = idx(shared.insert(in.gid));
      if (at < here.size()) {
        vert_.push_back(here[at]);
        continue;
      }
      fresh_.push_back(taken < gone.size() ? gone[taken++] : to_id<VertId>(end++));
      vert_.push_back(fresh_.back());
      if (in.shared != 0) here.push_back(fresh_.back());
    }
    gone.erase(gone.begin(), gone.begin() + static_cast<std::ptrdiff_t>(taken));
    unpack_columns(m_, layout_, load_.columns.items, vert_, fresh_, end);
    resize_vert2tet(m_, end);
    reserve_with_slack(dist_.vert2gid, end);
    dist_.vert2gid.resize(end);
    for (std::size_t i = 0; i < vert_.size(); ++i) dist_.vert2gid[vert_[i]] = load_.verts.items[i].gid;
  }

  /// Faces that were on the interface are added to `open`.
  void put_tets(std::vector<FaceId>& open) {
    const std::size_t n = load_.tets.items.size(), before = m_.tet_slots(), places = std::min(n, free_tets_.size());
    const auto place = [&](std::size_t i) { return i < places ? free_tets_[i] : to_id<TetId>(before + i - places); };
    resize_tets(m_, before + n - places);
    // Every block of tetrahedra has a block of vertices from the same rank.
    std::size_t feature_block = 0;
    for (std::size_t b = 0; b < load_.tets.blocks(); ++b) {
      const VertId* vert = vert_.data() + load_.verts.offset[b];
      const std::size_t first = load_.tets.offset[b];
      for (std::size_t i = first; i < load_.tets.offset[b + 1]; ++i) {
        const MovedTet& in = load_.tets.items[i];
        const TetId t = place(i);
        for (std::size_t k = 0; k < 4; ++k) {
          const VertId v = m_.tet2vert[t][k] = vert[in.vert[k]];
          m_.vert2tet[v] = t;
          const std::int32_t f = in.face[k];
          m_.tet2face[t][k] = f >= 0 ? make_face(place(first + static_cast<std::size_t>(f / 4)), f % 4) : kNoFace;
          if (f == kWasInterface) open.push_back(make_face(t, k));
        }
        m_.face_tag[t] = in.tag;
        m_.tet_ref[t] = in.ref;
        m_.tet_class[t] = in.tet_class;
      }
      if (feature_block < load_.features.blocks() && load_.features.rank[feature_block] == load_.tets.rank[b]) {
        for (const auto& e : load_.features.block(feature_block))
          m_.features.insert({vert[e.a], vert[e.b], e.ref, static_cast<FeatureClass>(e.edge_class)});
        ++feature_block;
      }
    }
    free_tets_.erase(free_tets_.begin(), free_tets_.begin() + static_cast<std::ptrdiff_t>(places));
  }

  DistMesh& dist_;
  TetMesh& m_;
  const ColumnLayout& layout_;
  const Load& load_;
  Staying staying_;
  std::vector<TetId> free_tets_;  ///< ascending
  std::vector<VertId> vert_;      ///< of what comes
  std::vector<VertId> fresh_;     ///< those of them that were not here
};

}  // namespace

void migrate(const Comm& comm, DistMesh& dist, const Moves& moves) {
  SKEIN_ASSERT_NO_FAULT_AT(2, check_sizes(dist.mesh));
  SKEIN_ASSERT_NORMAL(dist.vert2gid.size() == dist.mesh.vert_slots());
  SKEIN_ASSERT_NORMAL(moves.tets.size() == moves.to.size());
  SKEIN_ASSERT_NORMAL(std::is_sorted(moves.tets.begin(), moves.tets.end()));
  SKEIN_ASSERT_NORMAL(moves.tets.empty() || idx(moves.tets.back()) < dist.mesh.tet_slots());
  SKEIN_ASSERT_NO_FAULT_AT(3, check(dist.mesh));
  agree(comm, [&] {
    if (moves.to.size() != moves.tets.size() ||
        std::any_of(moves.to.begin(), moves.to.end(), [&](Rank r) { return num(r) < 0 || num(r) >= comm.size(); }))
      throw Error(ExitCode::kInternal, "migrate: destinations do not fit the tetrahedra or the ranks");
    if (std::count(dist.vert2gid.begin(), dist.vert2gid.end(), kNoGlobal) != 0)
      throw Error(ExitCode::kInternal, "migrate: vertices without global id (number_new_vertices comes first)");
  });
  const Leaving leaving = sort_out(comm, moves, dist.mesh.tet_slots());
  const auto features = features_by_rank(dist.mesh, leaving);
  const ColumnLayout layout = layout_of(comm, dist.mesh);
  Load in;
  {
    const Load out = Packer(dist, layout, leaving, features).pack();
    in.tets = exchange(comm, out.tets);
    in.verts = exchange(comm, out.verts);
    in.columns = exchange(comm, out.columns);
    in.features = exchange(comm, out.features);
  }
  std::vector<VertId> met = dist.sharing.vert;
  if (!leaving.none() || !in.tets.items.empty())
    met = Arrival(dist, layout, in, leaving, Stayers(dist, leaving, features).find(features, moves.open)).run();
  rebuild_sharing(comm, dist, met);
  merge_vertex_flags(comm, dist);
  count_global(comm, dist);
}

void migrate(const Comm& comm, DistMesh& dist, const IdVector<TetId, Rank>& dest) {
  agree(comm, [&] {
    if (dest.size() != dist.mesh.tet_slots())
      throw Error(ExitCode::kInternal, "migrate: destinations do not fit the tetrahedra");
  });
  Moves moves;
  for (const TetId t : IdRange<TetId>(dest.size())) {
    if (dest[t] == comm.rank()) continue;
    moves.tets.push_back(t);
    moves.to.push_back(dest[t]);
  }
  migrate(comm, dist, moves);
}

void migrate(const Comm& comm, DistMesh& dist, const IdVector<TetId, PartId>& dest) {
  migrate(comm, dist, to_ranks(dest));
}

}  // namespace skein
