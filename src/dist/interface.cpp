// Labels that spread from the interface, the active band, and global numbers.
#include "dist/interface.hpp"

#include <algorithm>
#include <numeric>

#include "dist/sharing.hpp"
#include "dist/winners.hpp"
#include "mesh/surroundings.hpp"

namespace skein {
namespace {

/// Edges from what is bad within which interfaces are moved: its neighbours have to change, too.
constexpr int kReach = 1;

Rank label_rank(std::int64_t label) noexcept { return to_id<Rank>(label & 0xffffffff); }

std::int64_t highest(const TetMesh& m, TetId t, const std::vector<std::int64_t>& label) noexcept {
  std::int64_t best = 0;
  for (const VertId v : m.tet2vert[t]) best = std::max(best, label[idx(v)]);
  return best;
}

}  // namespace

InterfaceRegion::InterfaceRegion(const Comm& comm, DistMesh& dist, int layers)
    : comm_(comm), dist_(dist), halo_(comm, dist.sharing), layers_(std::max(layers, kReach)) {}

InterfaceRegion::Labels& InterfaceRegion::no_labels() {
  label_.assign(dist_.mesh.vert_slots(), 0);
  return label_;
}

void InterfaceRegion::find_tets(GlobalId before) {
  if (found_) return;
  found_ = true;
  const TetMesh& m = dist_.mesh;
  const Sharing& sharing = dist_.sharing;
  std::vector<VertId> first;  // on interfaces that are moved as a whole
  IdVector<VertId, char> is_first(m.vert_slots(), 0);
  for (std::size_t i = 0; i < sharing.size(); ++i) {
    if (sharing.gid[i] >= before) continue;
    first.push_back(sharing.vert[i]);
    is_first[sharing.vert[i]] = 1;
  }
  std::vector<std::int64_t> mark(sharing.size());
  const auto is_marked = [&](VertId v) { return m.has(v, kRetry) && is_first[v] == 0; };
  for (std::size_t i = 0; i < mark.size(); ++i) mark[i] = is_marked(sharing.vert[i]) ? 1 : 0;
  std::vector<VertId> fresh;
  std::vector<char> reached(sharing.size(), 0);
  Surroundings near(m, {});
  // What this rank or another has marked on the interface is added with all that is at it here.
  const auto add_shared = [&] {
    halo_.max_shared(std::span<std::int64_t>(mark));
    fresh.clear();
    for (std::size_t i = 0; i < sharing.size(); ++i) {
      if (mark[i] == 0 || reached[i] != 0) continue;
      reached[i] = 1;
      fresh.push_back(sharing.vert[i]);
    }
    if (!fresh.empty()) near.add(fresh);
    near.add_tets();
  };
  const auto add_layer = [&] {
    near.add_vertices();
    for (std::size_t i = 0; i < mark.size(); ++i) mark[i] |= near.has(sharing.vert[i]) ? 1 : 0;
    add_shared();
  };
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (is_marked(v)) fresh.push_back(v);
  }
  if (!fresh.empty()) near.add(fresh);
  add_shared();
  for (int l = 0; l < kReach; ++l) add_layer();
  near_retry_ = near.found();
  if (!first.empty()) near.add(first);
  for (int l = 0; l < layers_; ++l) add_layer();
  tets_ = near.tets();
  open_ = near.all_open();
}

/// One layer: wanted vertices without a label take the highest of the tetrahedra at them, on all ranks.
template <class Wanted>
void InterfaceRegion::spread(const std::vector<TetId>& tets, Labels& label, Wanted&& wanted) const {
  const TetMesh& m = dist_.mesh;
  std::vector<VertId> reached;  // their new labels are negative until all have one
  for (const TetId t : tets) {
    const std::int64_t best = highest(m, t, label);
    if (best == 0) continue;
    for (const VertId v : m.tet2vert[t]) {
      std::int64_t& l = label[idx(v)];
      if (l > 0 || !wanted(v, best)) continue;
      if (l == 0) reached.push_back(v);
      l = std::min(l, -best);
    }
  }
  for (const VertId v : reached) label[idx(v)] = -label[idx(v)];
  halo_.max(std::span<std::int64_t>(label));
}

void InterfaceRegion::spread(const std::vector<TetId>& tets, Labels& label) const {
  spread(tets, label, [](VertId, std::int64_t) { return true; });
}

/// Per entry of dist.sharing: it shall become interior, if it can.
std::vector<char> InterfaceRegion::to_be_freed(GlobalId before) {
  const TetMesh& m = dist_.mesh;
  const Sharing& sharing = dist_.sharing;
  Labels& label = no_labels();
  for (const VertId v : IdRange<VertId>(m.vert_slots())) label[idx(v)] = m.has(v, kRetry) ? 1 : 0;
  for (std::size_t i = 0; i < sharing.size(); ++i) {
    if (sharing.gid[i] < before) label[idx(sharing.vert[i])] = 0;
  }
  halo_.max(std::span<std::int64_t>(label));
  for (int l = 0; l < kReach; ++l) spread(near_retry_, label);
  std::vector<char> wanted(sharing.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] = label[idx(sharing.vert[i])] != 0 || sharing.gid[i] < before ? 1 : 0;
  }
  return wanted;
}

Moves InterfaceRegion::displace(int layers, int round, GlobalId before) {
  const TetMesh& m = dist_.mesh;
  const Sharing& sharing = dist_.sharing;
  find_tets(before);
  const std::vector<char> wanted = to_be_freed(before);
  Labels& label = no_labels();
  if (round == 1) {
    const Winners winners(comm_, dist_, wanted, round);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const VertId v = sharing.vert[i];
      if (wanted[i] != 0) label[idx(v)] = winners.priority(winners.winner(sharing, i, m.coords[v]));
    }
  } else {
    const std::int64_t mine = least_first(static_cast<std::int64_t>(m.tet_slots()), comm_.rank());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (wanted[i] != 0) label[idx(sharing.vert[i])] = mine;
    }
    halo_.max(std::span<std::int64_t>(label));
  }
  for (int l = 0; l < layers; ++l) spread(tets_, label);
  Moves moves;
  moves.open = open_;
  for (const TetId t : tets_) {
    const std::int64_t best = highest(m, t, label);
    if (best == 0 || label_rank(best) == comm_.rank()) continue;
    moves.tets.push_back(t);
    moves.to.push_back(label_rank(best));
  }
  return moves;
}

bool InterfaceRegion::mark_active(int layers, GlobalId before) {
  constexpr std::int64_t kInterface = 1, kBad = 2;
  TetMesh& m = dist_.mesh;
  Labels& label = no_labels();
  for (const VertId v : IdRange<VertId>(m.vert_slots())) label[idx(v)] = m.has(v, kRetry) ? kBad : 0;
  for (const VertId v : dist_.sharing.vert) {
    if (dist_.vert2gid[v] < before) label[idx(v)] = std::max(label[idx(v)], kInterface);
  }
  halo_.max(std::span<std::int64_t>(label));
  std::int64_t any = 0;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    any |= label[idx(v)];
    if (label[idx(v)] != 0) m.vert_state[v] |= kRetry;
  }
  any = comm_.max(any);
  if (any != 0) find_tets(before);
  for (int l = 0; any != 0 && l < layers; ++l) {
    spread(tets_, label, [&](VertId v, std::int64_t best) { return best == kBad || m.has(v, kBesideFrozen); });
  }
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    m.vert_state[v] &= ~kActive;
    if (label[idx(v)] != 0) m.vert_state[v] |= kActive;
  }
  return any != 0;
}

GlobalId number_new_vertices(const Comm& comm, DistMesh& dist) {
  std::int64_t top = -1, fresh = 0;
  for (const GlobalId g : dist.vert2gid) {
    top = std::max(top, num(g));
    fresh += g == kNoGlobal ? 1 : 0;
  }
  const std::int64_t first = comm.max(top) + 1;
  std::int64_t next = first + comm.exclusive_sum(fresh);
  for (auto& g : dist.vert2gid) {
    if (g == kNoGlobal) g = GlobalId{next++};
  }
  count_global(comm, dist);
  return GlobalId{first};
}

std::vector<std::int64_t> compact_numbers(const Comm& comm, const DistMesh& dist) {
  const auto owned = owned_verts(comm, dist);
  std::int64_t next = comm.exclusive_sum(static_cast<std::int64_t>(std::count(owned.begin(), owned.end(), 1)));
  std::vector<std::int64_t> number(owned.size(), -1);
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (owned.raw()[v] != 0) number[v] = next++;
  }
  Halo(comm, dist.sharing).copy_from_owner(std::span<std::int64_t>(number));
  return number;
}

void renumber_compact(const Comm& comm, DistMesh& dist) {
  const auto number = compact_numbers(comm, dist);
  for (const VertId v : IdRange<VertId>(number.size())) dist.vert2gid[v] = GlobalId{number[idx(v)]};
  const Sharing& old = dist.sharing;
  std::vector<std::size_t> order(old.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return dist.vert2gid[old.vert[i]] < dist.vert2gid[old.vert[j]]; });
  Sharing s;
  for (const std::size_t i : order) {
    s.vert.push_back(old.vert[i]);
    s.gid.push_back(dist.vert2gid[old.vert[i]]);
    s.rank.insert(s.rank.end(), old.others(i).begin(), old.others(i).end());
    s.offset.push_back(s.rank.size());
  }
  dist.sharing = std::move(s);
  count_global(comm, dist);
}

}  // namespace skein
