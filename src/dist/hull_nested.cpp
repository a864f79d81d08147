// Pieces of the hull inside of the mesh: connected pieces, and the winding of the whole hull round a point of each.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "base/union_find.hpp"
#include "dist/hull_contact.hpp"
#include "dist/rendezvous.hpp"

namespace skein {
namespace {

enum class PieceFace : std::int32_t {};  ///< place in the list of faces

/// Points that are tested times faces of the hull, at most: what is left out are pieces of many-pieced hulls.
constexpr std::int64_t kMostTests = 5'000'000;

struct EdgeOfFace {
  std::array<GlobalId, 2> gid;  ///< ascending
  Rank rank;
  PieceFace face;
};
struct Link {
  Rank rank{-1};  ///< of the only other face at the edge; -1: there is not just one
  PieceFace face{};
};

/// Collective. The other face at each edge of each face (three links per face).
std::vector<Link> link_faces(const Comm& comm, const std::vector<HullFace>& faces) {
  std::vector<EdgeOfFace> edges;
  std::vector<Rank> dest;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(faces[i].gid[k], faces[i].gid[(k + 1) % 3]);
      edges.push_back({{a, b}, comm.rank(), to_id<PieceFace>(i)});
      dest.push_back(meeting_rank(hash_of(edges.back().gid), comm.size()));
    }
  }
  const Inquiry<EdgeOfFace> inquiry(comm, dest, edges);
  const auto& asked = inquiry.asked().items;
  std::vector<std::uint32_t> order(asked.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::sort(order.begin(), order.end(), [&](auto i, auto j) { return asked[i].gid < asked[j].gid; });
  std::vector<Link> links(asked.size());
  for (std::size_t i = 0, j = 0; i < order.size(); i = j) {
    for (j = i; j < order.size() && asked[order[j]].gid == asked[order[i]].gid;) ++j;
    if (j - i != 2) continue;
    const EdgeOfFace &a = asked[order[i]], &b = asked[order[i + 1]];
    links[order[i]] = {b.rank, b.face};
    links[order[i + 1]] = {a.rank, a.face};
  }
  return inquiry.answer(links);
}

/// The pieces of the hull; a piece is named after its tetrahedron of the lowest number, whatever the ranks.
class Pieces {
 public:
  using Name = std::int64_t;
  /// Collective.
  Pieces(const Comm& comm, const std::vector<HullFace>& faces) : comm_(comm), faces_(faces), sets_(faces.size()) {
    const std::vector<Link> links = link_faces(comm, faces);
    name_.resize(faces.size());
    for (const PieceFace f : IdRange<PieceFace>(faces.size())) {
      name_[f] = faces[idx(f)].tet;
      for (std::size_t k = 0; k < 3; ++k) {
        const Link& l = links[3 * idx(f) + k];
        if (l.rank == comm.rank()) sets_.join(f, l.face);
        if (l.rank != comm.rank() && l.rank != Rank{-1}) remote_.push_back({f, l});
      }
    }
    for (const PieceFace f : IdRange<PieceFace>(faces.size())) {
      Name& name = name_[sets_.root(f)];
      name = std::min(name, faces[idx(f)].tet);
    }
    while (spread()) {
    }
  }
  /// The faces here of tetrahedra after which their pieces are named.
  [[nodiscard]] std::vector<PieceFace> named_here() {
    std::vector<PieceFace> out;
    for (const PieceFace f : IdRange<PieceFace>(name_.size())) {
      if (name_[sets_.root(f)] == faces_[idx(f)].tet) out.push_back(f);
    }
    return out;
  }

 private:
  struct Remote {
    PieceFace face;
    Link link;
  };
  struct Message {
    Name name;
    std::int64_t face;
  };
  /// Collective. Names go to the other ranks' faces; true when one has changed anywhere.
  bool spread() {
    std::vector<Message> send;
    std::vector<Rank> dest;
    for (const Remote& r : remote_) {
      send.push_back({name_[sets_.root(r.face)], num(r.link.face)});
      dest.push_back(r.link.rank);
    }
    std::int64_t changes = 0;
    for (const Message& m : exchange_items(comm_, dest, send).items) {
      Name& name = name_[sets_.root(to_id<PieceFace>(m.face))];
      if (m.name >= name) continue;
      name = m.name;
      ++changes;
    }
    return comm_.sum(changes) > 0;
  }
  const Comm& comm_;
  const std::vector<HullFace>& faces_;
  UnionFind<PieceFace> sets_;
  IdVector<PieceFace, Name> name_;  ///< at the root of a set
  std::vector<Remote> remote_;
};

/// The solid angle of a triangle seen from p ([VanOosterom1983]); positive when p sees its back.
double solid_angle(const std::array<Vec3, 3>& x, Vec3 p) noexcept {
  const Vec3 a = x[0] - p, b = x[1] - p, c = x[2] - p;
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
}

std::array<GlobalId, 3> sorted(std::array<GlobalId, 3> v) noexcept {
  std::sort(v.begin(), v.end());
  return v;
}

struct Probe {
  HullFace face;
  std::int64_t here;  ///< the rank that has it
};

/// Collective. One face of each piece, the same on every rank; of very many pieces the first.
std::vector<Probe> choose_probes(const Comm& comm, const std::vector<HullFace>& faces, std::int64_t total_faces) {
  Pieces pieces(comm, faces);
  const auto mine = pieces.named_here();
  const std::int64_t before = comm.exclusive_sum(static_cast<std::int64_t>(mine.size()));
  const std::int64_t most = std::max<std::int64_t>(2, kMostTests / std::max<std::int64_t>(1, total_faces));
  std::vector<Probe> probes;
  for (std::size_t i = 0; i < mine.size() && before + static_cast<std::int64_t>(i) < most; ++i)
    probes.push_back({faces[idx(mine[i])], num(comm.rank())});
  probes = comm.all_gather(probes);
  std::sort(probes.begin(), probes.end(), [](const Probe& a, const Probe& b) {
    return std::pair(a.face.tet, sorted(a.face.gid)) < std::pair(b.face.tet, sorted(b.face.gid));
  });
  const auto same = [](const Probe& a, const Probe& b) { return a.face.tet == b.face.tet; };
  probes.erase(std::unique(probes.begin(), probes.end(), same), probes.end());
  return probes;
}

}  // namespace

std::vector<HullFault> find_nested(const Comm& comm, const std::vector<HullFace>& faces) {
  const auto probes = choose_probes(comm, faces, comm.sum(static_cast<std::int64_t>(faces.size())));
  if (probes.size() < 2) return {};  // one piece cannot be inside of another
  std::vector<double> angle(probes.size(), 0);
  for (std::size_t i = 0; i < probes.size(); ++i) {
    for (const HullFace& f : faces) angle[i] += solid_angle(f.x, probes[i].face.inside);
  }
  comm.reduce(std::span<double>(angle), Op::kSum);
  std::vector<HullFault> faults;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].here != num(comm.rank()) || angle[i] / (4 * std::numbers::pi) < 1.5) continue;
    const HullFace& f = probes[i].face;
    faults.push_back({HullFaultKind::kNested, 3, f.tet, -1, {f.gid[0], f.gid[1], f.gid[2], kNoGlobal}});
  }
  return faults;
}

}  // namespace skein
