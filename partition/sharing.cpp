// Sharing lists by rendezvous, flags and counts over the ranks.
#include "partition/sharing.hpp"

#include <algorithm>

#include "mesh/adjacency.hpp"
#include "mesh/surroundings.hpp"
#include "partition/rendezvous.hpp"

namespace skein {
namespace {

struct Copy {
  GlobalId gid;
  Rank rank;
};
bool before(const Copy& a, const Copy& b) noexcept { return a.gid != b.gid ? a.gid < b.gid : a.rank < b.rank; }

struct Candidate {
  GlobalId gid;
  VertId vert;
};

}  // namespace

std::vector<VertId> verts_of(const TetMesh& m, const std::vector<FaceId>& faces) {
  IdVector<VertId, char> seen(m.vert_slots(), 0);
  std::vector<VertId> out;
  for (const FaceId f : faces) {
    for (const VertId v : face_verts(m, f)) {
      if (seen[v] != 0) continue;
      seen[v] = 1;
      out.push_back(v);
    }
  }
  return out;
}

Sharing find_sharing(const Comm& comm, const std::vector<VertId>& among, const IdVector<VertId, GlobalId>& vert2gid) {
  std::vector<Candidate> candidates;
  for (const VertId v : among) {
    if (vert2gid[v] != kNoGlobal) candidates.push_back({vert2gid[v], v});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.gid < b.gid; });
  std::vector<Rank> dest(candidates.size());
  std::vector<Copy> copies(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    dest[i] = meeting_rank(candidates[i].gid, comm.size());
    copies[i] = {candidates[i].gid, comm.rank()};
  }
  auto met = exchange_items(comm, dest, copies).items;
  std::sort(met.begin(), met.end(), before);
  dest.clear();
  copies.clear();
  for (std::size_t i = 0; i < met.size();) {
    std::size_t j = i + 1;
    while (j < met.size() && met[j].gid == met[i].gid) ++j;
    for (std::size_t a = i; a < j && j - i > 1; ++a) {
      for (std::size_t b = i; b < j; ++b) {
        if (a == b) continue;
        dest.push_back(met[a].rank);
        copies.push_back(met[b]);
      }
    }
    i = j;
  }
  auto others = exchange_items(comm, dest, copies).items;
  std::sort(others.begin(), others.end(), before);
  Sharing s;
  s.rank.reserve(others.size());
  std::size_t c = 0;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (i == 0 || others[i].gid != others[i - 1].gid) {
      if (i > 0) s.offset.push_back(i);
      while (candidates[c].gid != others[i].gid) ++c;
      s.gid.push_back(others[i].gid);
      s.vert.push_back(candidates[c].vert);
    }
    s.rank.push_back(others[i].rank);
  }
  if (!others.empty()) s.offset.push_back(others.size());
  return s;
}

void rebuild_sharing(const Comm& comm, DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  std::vector<FaceId> open;
  visit_open_tets(m, [&](TetId t) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (m.is_live(t) && m.tet2face[t][k] == kNoFace) open.push_back(make_face(t, static_cast<int>(k)));
    }
  });
  rebuild_sharing(comm, dist, verts_of(m, open));
}

void rebuild_sharing(const Comm& comm, DistMesh& dist, const std::vector<VertId>& among) {
  dist.sharing = find_sharing(comm, among, dist.vert2gid);
  for (auto& f : dist.mesh.vert_flags) f = static_cast<std::uint8_t>(f & ~kFrozen);
  for (const VertId v : dist.sharing.vert) dist.mesh.vert_flags[v] |= kFrozen;
}

void merge_vertex_flags(const Comm& comm, DistMesh& dist) {
  // Each flag has its own 10 bits of a number, where it adds up over the copies.
  constexpr int kFlags = 6, kLane = 10;
  std::vector<std::int64_t> lanes(dist.mesh.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) {
    for (int b = 0; b < kFlags; ++b)
      lanes[idx(v)] |= static_cast<std::int64_t>(dist.mesh.vert_flags[v] >> b & 1) << (b * kLane);
  }
  Halo(comm, dist.sharing).sum(std::span<std::int64_t>(lanes));
  for (const VertId v : dist.sharing.vert) {
    for (int b = 0; b < kFlags; ++b) {
      if ((lanes[idx(v)] >> (b * kLane) & ((1 << kLane) - 1)) != 0)
        dist.mesh.vert_flags[v] = static_cast<std::uint8_t>(dist.mesh.vert_flags[v] | 1 << b);
    }
  }
}

IdVector<VertId, char> owned_verts(const Comm& comm, const DistMesh& dist) {
  IdVector<VertId, char> owned(dist.mesh.vert_slots(), 1);
  for (std::size_t i = 0; i < dist.sharing.size(); ++i)
    owned[dist.sharing.vert[i]] = comm.rank() < dist.sharing.others(i).front() ? 1 : 0;
  return owned;
}

void count_global(const Comm& comm, DistMesh& dist) {
  const auto owned = owned_verts(comm, dist);
  dist.global_verts = comm.sum(static_cast<std::int64_t>(std::count(owned.begin(), owned.end(), 1)));
  dist.global_tets = comm.sum(static_cast<std::int64_t>(dist.mesh.tet_slots()));
}

void compact(DistMesh& dist) {
  const auto old2new = compact(dist.mesh);
  const auto width = static_cast<std::size_t>(dist.data.width);
  IdVector<VertId, GlobalId> gid(dist.mesh.vert_slots(), kNoGlobal);
  std::vector<double> values(dist.mesh.vert_slots() * width);
  for (const VertId v : IdRange<VertId>(old2new.size())) {
    if (old2new[v] == kNoVert) continue;
    gid[old2new[v]] = dist.vert2gid[v];
    std::copy_n(dist.data.at(v), width, values.data() + idx(old2new[v]) * width);
  }
  dist.vert2gid = std::move(gid);
  dist.data.values = std::move(values);
  for (auto& v : dist.sharing.vert) v = old2new[v];
}

}  // namespace skein
