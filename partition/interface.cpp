// Labels that spread from the interface, the active band, and global numbers.
#include "partition/interface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "partition/duels.hpp"
#include "partition/sharing.hpp"

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

/// Calls visit(t) for the tetrahedra with a vertex that has a label. They are few, so a byte per vertex is asked first.
template <class Visit>
void for_each_labelled(const TetMesh& m, const std::vector<std::int64_t>& label, Visit&& visit) {
  IdVector<VertId, char> has(label.size());
  for (std::size_t i = 0; i < label.size(); ++i) has[to_id<VertId>(i)] = label[i] != 0 ? 1 : 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& v = m.tet2vert[t];
    if ((has[v[0]] | has[v[1]] | has[v[2]] | has[v[3]]) != 0) visit(t);
  }
}

/// One layer: vertices without a label (0) take the highest of the tetrahedra at them, on all ranks.
void spread(const DistMesh& dist, const Halo& halo, std::vector<std::int64_t>& label) {
  const TetMesh& m = dist.mesh;
  struct Reached {
    VertId v;
    std::int64_t label;
  };
  std::vector<Reached> reached;
  for_each_labelled(m, label, [&](TetId t) {
    const std::int64_t best = highest(m, t, label);
    for (const VertId v : m.tet2vert[t]) {
      if (label[idx(v)] == 0) reached.push_back({v, best});
    }
  });
  for (const Reached& r : reached) label[idx(r.v)] = std::max(label[idx(r.v)], r.label);
  halo.max(std::span<std::int64_t>(label));
}

/// Per entry of dist.sharing: it shall become interior, if it can.
std::vector<char> to_be_freed(const DistMesh& dist, const Halo& halo, GlobalId before) {
  const TetMesh& m = dist.mesh;
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) label[idx(v)] = m.has(v, kHeld) ? 1 : 0;
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) {
    if (dist.sharing.gid[i] < before) label[idx(dist.sharing.vert[i])] = 0;
  }
  halo.max(std::span<std::int64_t>(label));
  for (int l = 0; l < kReach; ++l) spread(dist, halo, label);
  std::vector<char> wanted(dist.sharing.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] = label[idx(dist.sharing.vert[i])] != 0 || dist.sharing.gid[i] < before ? 1 : 0;
  }
  return wanted;
}

}  // namespace

IdVector<TetId, Rank> displace_interface(const Comm& comm, const DistMesh& dist, int layers, int round,
                                         GlobalId before) {
  const TetMesh& m = dist.mesh;
  const Halo halo(comm, dist.sharing);
  const std::vector<char> wanted = to_be_freed(dist, halo, before);
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  if (round == 1) {
    const Duels duels(comm, dist, wanted, round);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const VertId v = dist.sharing.vert[i];
      if (wanted[i] != 0) label[idx(v)] = duels.priority(duels.winner(dist.sharing, i, m.coords[v]));
    }
  } else {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (wanted[i] != 0) label[idx(dist.sharing.vert[i])] = order_in_round(comm.rank(), round);
    }
    halo.max(std::span<std::int64_t>(label));
  }
  for (int l = 0; l < layers; ++l) spread(dist, halo, label);
  IdVector<TetId, Rank> dest(m.tet_slots(), comm.rank());
  for_each_labelled(m, label, [&](TetId t) { dest[t] = label_rank(highest(m, t, label)); });
  return dest;
}

bool mark_active_band(const Comm& comm, DistMesh& dist, int layers, GlobalId before) {
  TetMesh& m = dist.mesh;
  const Halo halo(comm, dist.sharing);
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) label[idx(v)] = m.has(v, kHeld) ? 1 : 0;
  for (const VertId v : dist.sharing.vert) label[idx(v)] |= dist.vert2gid[v] < before ? 1 : 0;
  halo.max(std::span<std::int64_t>(label));
  std::int64_t any = 0;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    any |= label[idx(v)];
    if (label[idx(v)] != 0) m.vert_flags[v] |= kHeld;
  }
  for (int l = 0; l < layers; ++l) spread(dist, halo, label);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    m.vert_flags[v] = static_cast<std::uint8_t>((m.vert_flags[v] & ~kActive) | (label[idx(v)] != 0 ? kActive : 0));
  }
  return comm.max(any) != 0;
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
