// Labels that spread from the interface, the active band, and global numbers.
#include "partition/interface.hpp"

#include <algorithm>
#include <numeric>

#include "partition/rendezvous.hpp"
#include "partition/sharing.hpp"

namespace skein {
namespace {

/// The rank in the low bits, above it what orders the ranks in this round; greater than 0.
std::int64_t priority(Rank r, int round) noexcept {
  const std::uint64_t h = mix(mix(static_cast<std::uint64_t>(round) + 1) ^ static_cast<std::uint64_t>(num(r)));
  return static_cast<std::int64_t>((h >> 34 | 1) << 32) | num(r);
}
Rank label_rank(std::int64_t label) noexcept { return to_id<Rank>(label & 0xffffffff); }

std::int64_t highest(const TetMesh& m, TetId t, const std::vector<std::int64_t>& label) noexcept {
  std::int64_t best = 0;
  for (const VertId v : m.tet2vert[t]) best = std::max(best, label[idx(v)]);
  return best;
}

/// One layer: vertices without a label (0) take the highest of the tetrahedra at them, on all ranks.
void spread(const DistMesh& dist, const Halo& halo, std::vector<std::int64_t>& label) {
  const TetMesh& m = dist.mesh;
  std::vector<std::int64_t> next(label);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const std::int64_t best = highest(m, t, label);
    if (best == 0) continue;
    for (const VertId v : m.tet2vert[t]) {
      if (label[idx(v)] == 0) next[idx(v)] = std::max(next[idx(v)], best);
    }
  }
  halo.max(std::span<std::int64_t>(next));
  label.swap(next);
}

}  // namespace

IdVector<TetId, Rank> displace_interface(const Comm& comm, const DistMesh& dist, int layers, int round) {
  const TetMesh& m = dist.mesh;
  const Halo halo(comm, dist.sharing);
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) label[idx(v)] = priority(comm.rank(), round);
  halo.max(std::span<std::int64_t>(label));
  for (int l = 0; l < layers; ++l) spread(dist, halo, label);
  IdVector<TetId, Rank> dest(m.tet_slots(), comm.rank());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const std::int64_t best = highest(m, t, label);
    if (best != 0) dest[t] = label_rank(best);
  }
  return dest;
}

void mark_active_band(const Comm& comm, DistMesh& dist, int layers) {
  TetMesh& m = dist.mesh;
  const Halo halo(comm, dist.sharing);
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) label[idx(v)] = 1;
  for (int l = 0; l < layers; ++l) spread(dist, halo, label);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    m.vert_flags[v] = static_cast<std::uint8_t>((m.vert_flags[v] & ~kActive) | (label[idx(v)] != 0 ? kActive : 0));
  }
}

void number_new_vertices(const Comm& comm, DistMesh& dist) {
  std::int64_t top = -1, fresh = 0;
  for (const GlobalId g : dist.vert2gid) {
    top = std::max(top, num(g));
    fresh += g == kNoGlobal ? 1 : 0;
  }
  std::int64_t next = comm.max(top) + 1 + comm.exclusive_sum(fresh);
  for (auto& g : dist.vert2gid) {
    if (g == kNoGlobal) g = GlobalId{next++};
  }
  count_global(comm, dist);
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
