// Reconciliation: faces by rendezvous, vertices by the sharing lists.
#include "dist/reconcile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/parallel.hpp"
#include "dist/rendezvous.hpp"
#include "dist/sharing.hpp"

namespace skein {
namespace {

/// Keeps the first fault it is told.
class Fault {
 public:
  template <class... Args>
  void tell(fmt::format_string<Args...> form, Args&&... args) {
    if (line_.empty()) line_ = fmt::format(form, std::forward<Args>(args)...);
  }
  [[nodiscard]] const std::string& line() const noexcept { return line_; }

 private:
  std::string line_;
};

/// All bits of a vertex that its copies must have in common.
std::uint64_t fingerprint(const DistMesh& dist, VertId v) noexcept {
  const Vec3 x = dist.mesh.coords[v];
  std::uint64_t h = mix(dist.vert2gid[v]);
  const auto add = [&h](double d) { h = mix(h ^ std::bit_cast<std::uint64_t>(d)); };
  add(x.x);
  add(x.y);
  add(x.z);
  if (!dist.mesh.log_metric.empty()) {
    const SymTensor& l = dist.mesh.log_metric[v];
    for (const double d : {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz}) add(d);
  }
  for (int c = 0; c < dist.mesh.fields.width; ++c) add(dist.mesh.fields.at(v)[c]);
  return h;
}

void check_arrays(const DistMesh& dist, Fault& fault) {
  const TetMesh& m = dist.mesh;
  const std::size_t nv = m.vert_slots(), nt = m.tet_slots();
  bool fit = m.vert_ref.size() == nv && m.vert_class.size() == nv && m.vert_state.size() == nv &&
             m.vert2tet.size() == nv && dist.vert2gid.size() == nv && m.tet2face.size() == nt &&
             m.face_tag.size() == nt && m.tet_ref.size() == nt;
  for_each_vert_column(m, [&](const auto& c) { fit = fit && (c.empty() || c.size() == nv); });
  if (!fit) fault.tell("the arrays of the mesh differ in length");
}

/// What one thread finds out about its tetrahedra.
struct Adjacency {
  Fault fault;
  std::vector<FaceId> open;     ///< faces without a local neighbour
  std::uint64_t one_sided = 0;  ///< sum of pair_hash(face, its neighbour)
};

/// Antisymmetric in its arguments, and else as good as random. Short, as there are many.
std::uint64_t pair_hash(FaceId f, FaceId g) noexcept {
  const auto a = static_cast<std::uint64_t>(num(f)), b = static_cast<std::uint64_t>(num(g));
  return scramble(a) * (2 * b + 1) - scramble(b) * (2 * a + 1);
}

/// All faces of the tetrahedra [first, last) are inside and have neighbours that can be; adds to the sum if so.
bool add_inner(const TetMesh& m, std::size_t first, std::size_t last, std::uint64_t& sum) {
  const auto* face = m.tet2face.raw()[first].data();
  const auto* tag = m.face_tag.raw()[first].data();
  const std::size_t n = 4 * (last - first);
  const auto end = static_cast<std::int32_t>(4 * m.tet_slots()), base = static_cast<std::int32_t>(4 * first);
  std::int32_t odd = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t f = num(face[i]);
    odd |= (f < 0 ? 1 : 0) | (f >= end ? 1 : 0) | (f == base + static_cast<std::int32_t>(i) ? 1 : 0) |
           (is_hull(tag[i]) ? 1 : 0);
  }
  if (odd != 0) return false;
  std::uint64_t of_these = 0;
  for (std::size_t i = 0; i < n; ++i) of_these += pair_hash(FaceId{base + static_cast<std::int32_t>(i)}, face[i]);
  sum += of_these;
  return true;
}

/// Of the tetrahedra [first, last). Looks at no other ones: neighbours lie far from each other in memory.
void check_adjacency(const DistMesh& dist, std::size_t first, std::size_t last, Adjacency& out) {
  constexpr std::size_t kAtOnce = 32;
  const TetMesh& m = dist.mesh;
  for (std::size_t i = first; i < last; i += kAtOnce) {
    const std::size_t end = std::min(last, i + kAtOnce);
    if (add_inner(m, i, end, out.one_sided)) continue;
    for (const FaceId me : IdRange<FaceId>(4 * i, 4 * end)) {
      const auto k = face_side(me);
      const FaceId f = m.tet2face[face_tet(me)][k];
      if (f == kNoFace) {
        out.open.push_back(me);
        continue;
      }
      if (f == me || num(f) < 0 || idx(face_tet(f)) >= m.tet_slots())
        return out.fault.tell("tetrahedron {}, face {}: its neighbour does not name it back", num(face_tet(me)), k);
      if (is_hull(m.face_tag[face_tet(me)][k]))
        return out.fault.tell("tetrahedron {}, face {}: a hull face has a neighbour", num(face_tet(me)), k);
      out.one_sided += pair_hash(me, f);
    }
  }
}

/// Tells the first face whose neighbour does not name it back. @pre all neighbours are faces of this mesh
void find_one_sided(const TetMesh& m, Fault& fault) {
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceId f = m.tet2face[t][k], me = make_face(t, k);
      if (f == kNoFace || m.neighbour(f) == me) continue;
      return fault.tell("tetrahedron {}, face {}: its neighbour does not name it back", num(t), k);
    }
  }
}

/// Gives the faces without a local neighbour, ascending. Where neighbours name each other, (face, neighbour) and
/// (neighbour, face) cancel in a sum of antisymmetric hashes; only where that is not 0 is it found out which face it
/// is.
std::vector<FaceId> check_adjacency(const DistMesh& dist, int threads, Fault& fault) {
  std::vector<Adjacency> found(static_cast<std::size_t>(threads));
  const std::size_t n = dist.mesh.tet_slots();
  in_parallel(threads, [&](int w) {
    check_adjacency(dist, share_begin(n, w, threads), share_begin(n, w + 1, threads), found[w]);
  });
  std::vector<FaceId> open;
  std::uint64_t one_sided = 0;
  for (const Adjacency& a : found) {
    if (!a.fault.line().empty()) fault.tell("{}", a.fault.line());
    open.insert(open.end(), a.open.begin(), a.open.end());
    one_sided += a.one_sided;
  }
  if (fault.line().empty() && one_sided != 0) find_one_sided(dist.mesh, fault);
  return open;
}

struct OuterFace {
  std::array<GlobalId, 3> gid;
  std::uint64_t bits;
  std::int32_t tag;
  std::int32_t odd;
};

/// Those of these faces without a local neighbour that other ranks may have. Tells vertices without a number, and
/// interface vertices that are not shared.
std::vector<OuterFace> outer_faces(const DistMesh& dist, const std::vector<FaceId>& open, Fault& fault) {
  const TetMesh& m = dist.mesh;
  IdVector<VertId, char> shared(m.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) shared[v] = 1;
  std::vector<OuterFace> faces;
  for (const FaceId f : open) {
    const FaceTag tag = m.tag(f);
    const auto v = m.verts(f);
    const bool all_shared = (shared[v[0]] & shared[v[1]] & shared[v[2]]) != 0;
    if (is_hull(tag) && !all_shared) continue;  // nobody else can have it, or check_lists finds a copy of its vertices
    for (const VertId w : v) {
      if (is_hull(tag) || (shared[w] != 0 && dist.vert2gid[w] != kNoGlobal)) continue;
      fault.tell("vertex {} (global id) is on an interface face but in no sharing list", num(dist.vert2gid[w]));
    }
    const FaceKey key = face_key(m, dist.vert2gid, f);
    const std::uint64_t bits = fingerprint(dist, v[0]) + fingerprint(dist, v[1]) + fingerprint(dist, v[2]);
    faces.push_back({key.gid, bits, tag, key.odd ? 1 : 0});
  }
  return faces;
}

void judge_faces(std::vector<OuterFace> met, Fault& fault) {
  std::sort(met.begin(), met.end(), [](const OuterFace& a, const OuterFace& b) { return a.gid < b.gid; });
  for (std::size_t i = 0; i < met.size();) {
    std::size_t j = i + 1;
    while (j < met.size() && met[j].gid == met[i].gid) ++j;
    const OuterFace &a = met[i], &b = met[j - 1];
    const bool hull = is_hull(static_cast<FaceTag>(a.tag));
    const auto name = [&] {
      return fmt::format("face {} {} {} (global ids)", num(a.gid[0]), num(a.gid[1]), num(a.gid[2]));
    };
    if (j - i != (hull ? 1u : 2u)) {
      fault.tell("{} {} {} copies", hull ? "hull" : "interface", name(), j - i);
    } else if (!hull && a.odd == b.odd) {
      fault.tell("interface {} has both tetrahedra on one side", name());
    } else if (!hull && a.bits != b.bits) {
      fault.tell("interface {} differs between its two ranks in coordinates or data", name());
    } else if (!hull && a.tag != b.tag) {
      fault.tell("interface {} has tag {} on one rank and {} on the other", name(), a.tag, b.tag);
    }
    i = j;
  }
}

struct SharedVertex {
  GlobalId gid;
  std::uint64_t bits;
  std::int64_t copies;
  std::int64_t flags;
  friend bool operator==(const SharedVertex&, const SharedVertex&) = default;
};

/// What each rank says of the vertices it shares with another must be what that one says.
void check_shared(const Comm& comm, const DistMesh& dist, Fault& fault) {
  std::vector<Rank> dest;
  std::vector<SharedVertex> items;
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) {
    const VertId v = dist.sharing.vert[i];
    const SharedVertex item{dist.vert2gid[v], fingerprint(dist, v),
                            static_cast<std::int64_t>(dist.sharing.others(i).size()),
                            static_cast<std::int64_t>(dist.mesh.vert_class[v] & kStays)};
    if (item.gid != dist.sharing.gid[i])
      fault.tell("vertex {} (global id) has another id in the sharing list", num(item.gid));
    for (const Rank r : dist.sharing.others(i)) {
      dest.push_back(r);
      items.push_back(item);
    }
  }
  const auto sent = pack(std::span<const Rank>(dest), std::span<const SharedVertex>(items));
  const auto got = exchange(comm, sent);
  if (sent.rank != got.rank || sent.offset != got.offset) {
    fault.tell("the sharing lists of two ranks differ in length");
    return;
  }
  for (std::size_t i = 0; i < got.items.size(); ++i) {
    const SharedVertex &a = sent.items[i], &b = got.items[i];
    if (a == b) continue;
    if (a.gid != b.gid) return fault.tell("the sharing lists of two ranks differ at vertex {} (global id)", num(a.gid));
    return fault.tell("vertex {} (global id) differs between its ranks in {}", num(a.gid),
                      a.bits != b.bits       ? "coordinates or data"
                      : a.copies != b.copies ? "the number of copies"
                                             : "its flags");
  }
}

/// A global id that is there twice; kNoGlobal if there is none.
GlobalId first_repeated(const IdVector<VertId, GlobalId>& ids) {
  constexpr std::uint64_t kMostBits = 64;  // per vertex
  GlobalId low = ids.empty() ? kNoGlobal : *ids.begin(), high = low;
  for (const GlobalId g : ids) low = std::min(low, g), high = std::max(high, g);
  const auto place = [&](GlobalId g) {
    return static_cast<std::uint64_t>(num(g)) - static_cast<std::uint64_t>(num(low));
  };
  if (place(high) < kMostBits * ids.size()) {
    std::vector<bool> seen(place(high) + 1, false);
    for (const GlobalId g : ids) {
      auto bit = seen[place(g)];
      if (bit && g != kNoGlobal) return g;
      bit = true;
    }
    return kNoGlobal;
  }
  GidMap seen(ids.size());
  std::size_t numbered = 0;
  for (const GlobalId g : ids) {
    if (g == kNoGlobal) continue;
    seen.insert(g);
    if (seen.size() != ++numbered) return g;
  }
  return kNoGlobal;
}

void check_lists(const Comm& comm, const DistMesh& dist, const std::vector<FaceId>& open, Fault& fault) {
  const Sharing truth = find_sharing(comm, verts_of(dist.mesh, open), dist.vert2gid);
  const Sharing& s = dist.sharing;
  if (truth.gid != s.gid || truth.vert != s.vert || truth.offset != s.offset || truth.rank != s.rank)
    fault.tell("the sharing list ({} vertices) does not name the copies that there are ({} vertices)", s.size(),
               truth.size());
  const GlobalId twice = first_repeated(dist.vert2gid);
  if (twice != kNoGlobal) fault.tell("vertex {} (global id) is twice on one rank", num(twice));
}

void check_counts(const Comm& comm, const DistMesh& dist, Fault& fault) {
  DistMesh counted;
  const auto owned = owned_verts(comm, dist);
  counted.global_verts = comm.sum(static_cast<std::int64_t>(std::count(owned.begin(), owned.end(), 1)));
  counted.global_tets = comm.sum(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  if (counted.global_tets != dist.global_tets || counted.global_verts != dist.global_verts)
    fault.tell("there are {} tetrahedra and {} vertices, not {} and {} as noted", counted.global_tets,
               counted.global_verts, dist.global_tets, dist.global_verts);
}

void agree_on(const Comm& comm, const Fault& fault) {
  agree(comm, [&] {
    if (!fault.line().empty()) throw Error(ExitCode::kInternal, "the parts do not fit together: " + fault.line());
  });
}

}  // namespace

void reconcile(const Comm& comm, const DistMesh& dist, int threads) {
  Fault fault;
  check_arrays(dist, fault);
  agree_on(comm, fault);  // what follows relies on it
  const std::vector<FaceId> open = check_adjacency(dist, threads, fault);
  const auto faces = outer_faces(dist, open, fault);
  std::vector<Rank> dest(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) dest[i] = meeting_rank(faces[i].gid, comm.size());
  judge_faces(exchange_items(comm, dest, faces).items, fault);
  check_shared(comm, dist, fault);
  check_lists(comm, dist, open, fault);
  check_counts(comm, dist, fault);
  agree_on(comm, fault);
}

}  // namespace skein
