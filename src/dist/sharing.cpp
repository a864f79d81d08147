// Sharing lists by rendezvous, flags and counts over the ranks.
#include "dist/sharing.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "dist/rendezvous.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/surroundings.hpp"

namespace skein {
namespace {

struct Copy {
  GlobalId gid;
  Rank rank;
};

/// The order of the items by global id; equal ones as they come.
template <class Gid>
std::vector<KeyIndex> order_by_gid(std::size_t n, Gid&& gid_of) {
  std::vector<KeyIndex> order(n);
  for (std::size_t i = 0; i < n; ++i)
    order[i] = {static_cast<std::uint64_t>(num(gid_of(i))), static_cast<std::uint32_t>(i)};
  radix_sort(order);
  return order;
}
std::vector<KeyIndex> order_by_gid(const std::vector<Copy>& copies) {
  return order_by_gid(copies.size(), [&](std::size_t i) { return copies[i].gid; });
}

}  // namespace

std::vector<VertId> verts_of(const TetMesh& m, const std::vector<FaceId>& faces) {
  IdVector<VertId, char> seen(m.vert_slots(), 0);
  std::vector<VertId> out;
  for (const FaceId f : faces) {
    for (const VertId v : m.verts(f)) {
      if (seen[v] != 0) continue;
      seen[v] = 1;
      out.push_back(v);
    }
  }
  return out;
}

Sharing find_sharing(const Comm& comm, const std::vector<VertId>& among, const IdVector<VertId, GlobalId>& vert2gid) {
  std::vector<VertId> verts;
  verts.reserve(among.size());
  std::copy_if(among.begin(), among.end(), std::back_inserter(verts),
               [&](VertId v) { return vert2gid[v] != kNoGlobal; });
  const auto candidates = order_by_gid(verts.size(), [&](std::size_t i) { return vert2gid[verts[i]]; });
  std::vector<Rank> dest(candidates.size());
  std::vector<Copy> copies(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    copies[i] = {GlobalId{static_cast<std::int64_t>(candidates[i].key)}, comm.rank()};
    dest[i] = meeting_rank(copies[i].gid, comm.size());
  }
  // What comes is by rank, and the sort keeps that among equal ids.
  const auto met = exchange_items(comm, dest, copies).items;
  const auto order = order_by_gid(met);
  dest.clear();
  copies.clear();
  for (std::size_t i = 0; i < order.size();) {
    std::size_t j = i + 1;
    while (j < order.size() && order[j].key == order[i].key) ++j;
    for (std::size_t a = i; a < j && j - i > 1; ++a) {
      for (std::size_t b = i; b < j; ++b) {
        if (a == b) continue;
        dest.push_back(met[order[a].index].rank);
        copies.push_back(met[order[b].index]);
      }
    }
    i = j;
  }
  // All copies of a vertex come from the one rank where they have met, in order.
  const auto others = exchange_items(comm, dest, copies).items;
  const auto by_gid = order_by_gid(others);
  Sharing s;
  s.rank.reserve(others.size());
  std::size_t c = 0;
  for (std::size_t i = 0; i < by_gid.size(); ++i) {
    if (i == 0 || by_gid[i].key != by_gid[i - 1].key) {
      if (i > 0) s.offset.push_back(i);
      while (candidates[c].key != by_gid[i].key) ++c;
      s.gid.push_back(others[by_gid[i].index].gid);
      s.vert.push_back(verts[candidates[c].index]);
    }
    s.rank.push_back(others[by_gid[i].index].rank);
  }
  if (!others.empty()) s.offset.push_back(others.size());
  return s;
}

void rebuild_sharing(const Comm& comm, DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  std::vector<FaceId> open;
  visit_open_tets(m, [&](TetId t) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (m.is_live(t) && m.tet2face[t][k] == kNoFace) open.push_back(make_face(t, k));
    }
  });
  rebuild_sharing(comm, dist, verts_of(m, open));
}

void rebuild_sharing(const Comm& comm, DistMesh& dist, const std::vector<VertId>& among) {
  dist.sharing = find_sharing(comm, among, dist.vert2gid);
  for (VertState& s : dist.mesh.vert_state) s &= ~kFrozen;
  for (const VertId v : dist.sharing.vert) dist.mesh.vert_state[v] |= kFrozen;
}

namespace {

constexpr VertState kSharedStates = kFrozen | kActive;
constexpr int kStateBits = 8 * sizeof(VertState);

/// The flags that copies must have in common as one number, and back.
std::int64_t shared_bits(const TetMesh& m, VertId v) noexcept {
  return static_cast<std::int64_t>(m.vert_class[v]) << kStateBits |
         static_cast<std::int64_t>(m.vert_state[v] & kSharedStates);
}
void add_bits(TetMesh& m, VertId v, std::int64_t bits) noexcept {
  m.vert_class[v] |= static_cast<VertClass>(bits >> kStateBits);
  m.vert_state[v] |= static_cast<VertState>(bits & ((1 << kStateBits) - 1));
}

}  // namespace

void merge_vertex_flags(const Comm& comm, DistMesh& dist) {
  const std::vector<VertId>& verts = dist.sharing.vert;
  std::vector<std::int64_t> bits(verts.size());
  for (std::size_t i = 0; i < verts.size(); ++i) bits[i] = shared_bits(dist.mesh, verts[i]);
  Halo(comm, dist.sharing).or_shared(std::span<std::int64_t>(bits));
  for (std::size_t i = 0; i < verts.size(); ++i) add_bits(dist.mesh, verts[i], bits[i]);
}

IdVector<VertId, char> owned_verts(const Comm& comm, const DistMesh& dist) {
  IdVector<VertId, char> owned(dist.mesh.vert_slots(), 1);
  for (std::size_t i = 0; i < dist.sharing.size(); ++i)
    owned[dist.sharing.vert[i]] = comm.rank() < dist.sharing.others(i).front() ? 1 : 0;
  return owned;
}

void count_global(const Comm& comm, DistMesh& dist) {
  auto owned = static_cast<std::int64_t>(dist.mesh.vert_slots());
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) owned -= dist.sharing.owned(i, comm.rank()) ? 0 : 1;
  dist.global_verts = comm.sum(owned);
  dist.global_tets = comm.sum(static_cast<std::int64_t>(dist.mesh.tet_slots()));
}

void compact(DistMesh& dist) {
  const auto old2new = compact(dist.mesh);
  permute(dist.vert2gid, old2new, dist.mesh.vert_slots());
  for (auto& v : dist.sharing.vert) v = old2new[v];
}

}  // namespace skein
