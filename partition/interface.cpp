// Labels that spread from the interface, the active band, and global numbers.
#include "partition/interface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "mesh/hilbert.hpp"
#include "partition/rendezvous.hpp"
#include "partition/sharing.hpp"

namespace skein {
namespace {

constexpr double kMostCells = 4;  ///< per axis of the interface's box: regions with an order of ranks of their own
constexpr double kCopiesPerCell = 800;  ///< shared vertices, each copy counted, that a cell should have

/// The box of all shared vertices of all ranks.
Box interface_box(const Comm& comm, const DistMesh& dist) {
  constexpr double kBig = 1e300;
  std::array<double, 6> low{kBig, kBig, kBig, kBig, kBig, kBig};  // the last three are those of -x
  for (const VertId v : dist.sharing.vert) {
    const Vec3 x = dist.mesh.coords[v];
    const std::array<double, 6> here{x.x, x.y, x.z, -x.x, -x.y, -x.z};
    for (std::size_t i = 0; i < 6; ++i) low[i] = std::min(low[i], here[i]);
  }
  comm.reduce(std::span<double>(low), Op::kMin);
  return {{low[0], low[1], low[2]}, {-low[3], -low[4], -low[5]}};
}

/// Cells per axis of the interface's box, so that a cell has some hundred interface vertices: where cells of different
/// winners meet, the old interface stays, and that should be little of it.
int cells_per_axis(const Comm& comm, const DistMesh& dist) {
  const auto copies = comm.sum(static_cast<double>(dist.sharing.size()));
  return static_cast<int>(std::clamp(std::sqrt(copies / kCopiesPerCell), 1.0, kMostCells));
}

/// Number of the cell of x among cells^3 in the box, the cells being moved with the round.
std::uint64_t cell_of(Vec3 x, const Box& box, int cells, int round) noexcept {
  if (cells == 1) return 0;
  const double shift = 0.5 * round;
  const auto axis = [&](double at, double low, double high) {
    return high > low ? static_cast<std::uint64_t>(cells * (at - low) / (high - low) + shift) : 0;
  };
  return axis(x.x, box.low.x, box.high.x) << 40 | axis(x.y, box.low.y, box.high.y) << 20 |
         axis(x.z, box.low.z, box.high.z);
}

/// The rank in the low bits, above it what orders the ranks in this round and cell; greater than 0. Each cell has its
/// own order, so that no rank takes all of its neighbours.
std::int64_t priority(Rank r, int round, std::uint64_t cell) noexcept {
  const std::uint64_t h =
      mix(mix(mix(static_cast<std::uint64_t>(round) + 1) ^ cell) ^ static_cast<std::uint64_t>(num(r)));
  return static_cast<std::int64_t>((h >> 34 | 1) << 32) | num(r);
}
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

}  // namespace

IdVector<TetId, Rank> displace_interface(const Comm& comm, const DistMesh& dist, int layers, int round,
                                         GlobalId before) {
  const TetMesh& m = dist.mesh;
  const Halo halo(comm, dist.sharing);
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  const Box box = interface_box(comm, dist);
  const int cells = cells_per_axis(comm, dist);
  for (const VertId v : dist.sharing.vert) {
    if (dist.vert2gid[v] >= before) continue;
    label[idx(v)] = priority(comm.rank(), round, cell_of(m.coords[v], box, cells, round));
  }
  halo.max(std::span<std::int64_t>(label));
  for (int l = 0; l < layers; ++l) spread(dist, halo, label);
  IdVector<TetId, Rank> dest(m.tet_slots(), comm.rank());
  for_each_labelled(m, label, [&](TetId t) { dest[t] = label_rank(highest(m, t, label)); });
  return dest;
}

bool mark_active_band(const Comm& comm, DistMesh& dist, int layers, GlobalId before) {
  TetMesh& m = dist.mesh;
  const Halo halo(comm, dist.sharing);
  std::vector<std::int64_t> label(m.vert_slots(), 0);
  std::int64_t any = 0;
  for (const VertId v : dist.sharing.vert) any |= label[idx(v)] = dist.vert2gid[v] < before ? 1 : 0;
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
