// Faces in distribute(): neighbours on the rank, the hull and the interface by rendezvous, and tags from the triangles.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/error.hpp"
#include "dist/distribute_steps.hpp"

namespace skein::distributing {
namespace {

/// A face under its smallest vertex.
struct FaceUnder {
  VertId mid, high;
  std::int32_t face_odd;  ///< 2 * face + odd... face ids stay below 2^30, see match_locally
};

/// Links the faces of exactly two local tetrahedra, one on each side. All others stay open: the rendezvous judges them.
void match_locally(TetMesh& m) {
  const std::size_t nv = m.vert_slots(), nt = m.tet_slots();
  m.tet2face.assign(nt, {kNoFace, kNoFace, kNoFace, kNoFace});
  m.vert2tet.assign(nv, kNoTet);
  const auto sorted = [&](FaceId f) {
    auto v = m.verts(f);
    bool odd = false;
    if (v[1] < v[0]) std::swap(v[0], v[1]), odd = !odd;
    if (v[2] < v[1]) std::swap(v[1], v[2]), odd = !odd;
    if (v[1] < v[0]) std::swap(v[0], v[1]), odd = !odd;
    return std::pair(v, odd);
  };
  std::vector<std::uint32_t> offset(nv + 1, 0);
  for (const FaceId f : IdRange<FaceId>(4 * nt)) {
    const auto v = m.verts(f);
    ++offset[idx(std::min({v[0], v[1], v[2]})) + 1];
    m.vert2tet[m.apex(f)] = face_tet(f);
  }
  std::partial_sum(offset.begin(), offset.end(), offset.begin());
  std::vector<FaceUnder> under(4 * nt);
  for (const FaceId f : IdRange<FaceId>(4 * nt)) {
    const auto [v, odd] = sorted(f);
    under[offset[idx(v[0])]++] = {v[1], v[2], odd ? ~num(f) : num(f)};
  }
  const auto key = [](const FaceUnder& a) {
    return static_cast<std::uint64_t>(num(a.mid)) << 32 | static_cast<std::uint32_t>(num(a.high));
  };
  const auto less = [&](const FaceUnder& a, const FaceUnder& b) { return key(a) < key(b); };
  const auto link = [&](FaceId f, FaceId g) { m.neighbour(f) = g; };
  std::size_t begin = 0;
  for (std::size_t v = 0; v < nv; ++v) {
    const std::size_t end = offset[v];  // the fill has moved each offset to its end
    std::sort(under.begin() + static_cast<std::ptrdiff_t>(begin), under.begin() + static_cast<std::ptrdiff_t>(end),
              less);
    for (std::size_t i = begin; i < end;) {
      std::size_t j = i + 1;
      while (j < end && !less(under[i], under[j])) ++j;
      if (j - i == 2 && (under[i].face_odd < 0) != (under[i + 1].face_odd < 0)) {
        const auto plain = [](std::int32_t f) { return FaceId{f < 0 ? ~f : f}; };
        link(plain(under[i].face_odd), plain(under[i + 1].face_odd));
        link(plain(under[i + 1].face_odd), plain(under[i].face_odd));
      }
      i = j;
    }
    begin = end;
  }
}

/// One side of a face.
struct Side {
  std::array<GlobalId, 3> gid;
  GlobalId opposite;
  std::int64_t tet;  ///< number in the file
  std::int32_t ref;
  std::int32_t odd;
};
struct Triangle {
  std::array<GlobalId, 3> gid;
  std::int64_t number;
  std::int32_t ref;
  std::int32_t required;
};
struct Verdict {
  FaceTag tag = 0;
  std::uint8_t speaks = 0;
  std::uint8_t again = 0;  ///< the tetrahedron is given again: drop it
};

// Patch numbers that are not known yet when a face is judged.
constexpr FaceTag kBareHull = kPatchMask, kBareRegion = kPatchMask - 1;
constexpr std::size_t kMaxPatches = kPatchMask - 4;

/// The faces that need more than local knowledge.
std::vector<FaceId> faces_to_judge(const Growing& g) {
  const TetMesh& m = g.dist.mesh;
  std::vector<FaceId> out;
  for (const FaceId f : IdRange<FaceId>(4 * m.tet_slots())) {
    const FaceId other = m.neighbour(f);
    bool judge = other == kNoFace || m.tet_ref[face_tet(f)] != m.tet_ref[face_tet(other)];
    if (!judge) {
      const auto v = m.verts(f);
      judge = (m.has(v[0], kSurface) && m.has(v[1], kSurface) && m.has(v[2], kSurface)) ||
              (g.many[v[0]] != 0 && g.many[v[1]] != 0 && g.many[v[2]] != 0);
    }
    if (judge) out.push_back(f);
  }
  return out;
}

/// Patch of each reference: the distinct references of all triangles, ascending.
std::vector<std::int32_t> collect_patches(const FileSource& src) {
  std::vector<std::int32_t> refs(src.file.triangles.ref);
  const auto distinct = [&] {
    std::sort(refs.begin(), refs.end());
    refs.erase(std::unique(refs.begin(), refs.end()), refs.end());
  };
  distinct();
  agree(src.comm, [&] {
    if (refs.size() > kMaxPatches)
      throw Error(ExitCode::kInvalidMesh, fmt::format("{}: more than {} different triangle references; merge some",
                                                      src.file.path, kMaxPatches));
  });
  refs = src.comm.all_gather(refs);
  distinct();
  if (refs.size() > kMaxPatches)  // the same on all ranks
    throw Error(ExitCode::kInvalidMesh,
                fmt::format("{}: {} different triangle references, at most {} are possible; merge some", src.file.path,
                            refs.size(), kMaxPatches));
  return refs;
}

/// The meeting of sides and triangles on one rank.
class Court {
 public:
  Court(const std::vector<Side>& sides, std::vector<Triangle> triangles, const std::vector<std::int32_t>& patch_ref)
      : sides_(sides), triangles_(std::move(triangles)), patch_ref_(patch_ref), verdicts(sides.size()) {}

  void judge() {
    std::vector<std::uint32_t> order(sides_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
      return std::pair(sides_[i].gid, sides_[i].tet) < std::pair(sides_[j].gid, sides_[j].tet);
    });
    std::sort(triangles_.begin(), triangles_.end(), [](const Triangle& a, const Triangle& b) {
      return std::pair(a.gid, a.number) < std::pair(b.gid, b.number);
    });
    std::size_t t = 0;
    for (std::size_t i = 0; i < order.size();) {
      std::size_t j = i + 1;
      while (j < order.size() && sides_[order[j]].gid == sides_[order[i]].gid) ++j;
      Triangle* triangle = nullptr;
      for (; t < triangles_.size() && triangles_[t].gid <= sides_[order[i]].gid; ++t)
        take(triangles_[t], triangles_[t].gid == sides_[order[i]].gid, triangle);
      judge_face({order.data() + i, j - i}, triangle);
      i = j;
    }
    for (; t < triangles_.size(); ++t) {
      Triangle* none = nullptr;
      take(triangles_[t], false, none);
    }
  }

 private:
  void take(const Triangle& t, bool is_face, Triangle*& triangle) {
    const Offence o{t.number, -1, {t.gid[0], t.gid[1], t.gid[2], kNoGlobal}};
    if (!is_face) {
      stray_triangles.push_back(o);
    } else if (triangle == nullptr) {
      first_ = t;
      triangle = &first_;
    } else if (triangle->ref != t.ref) {
      double_triangles.push_back({triangle->number, t.number, o.verts});
    } else {
      triangle->required |= t.required;
      ++triangles_again;
    }
  }

  /// Tetrahedra given several times come here with four faces each; the one opposite to the highest vertex speaks.
  void judge_copies(std::span<const std::uint32_t> group) {
    for (std::size_t k = 1; k < group.size(); ++k) {
      const Side& d = sides_[group[k]];
      if (d.opposite < d.gid[2]) continue;
      const auto same = std::find_if(group.begin(), group.begin() + static_cast<std::ptrdiff_t>(k),
                                     [&](std::uint32_t i) { return sides_[i].opposite == d.opposite; });
      const Side& c = sides_[*same];
      if (&c == &d) continue;
      if (c.ref != d.ref) double_tets.push_back({c.tet, d.tet, {c.gid[0], c.gid[1], c.gid[2], c.opposite}});
      verdicts[group[k]].again = 1;
      ++tets_again;
    }
  }

  void judge_face(std::span<const std::uint32_t> group, const Triangle* triangle) {
    const Side &a = sides_[group.front()], &b = sides_[group.back()];
    const Offence offence{a.tet, b.tet, {a.gid[0], a.gid[1], a.gid[2], kNoGlobal}};
    judge_copies(group);
    if (group.size() > 2) return crowded.push_back(offence);
    if (group.size() == 2 && a.odd == b.odd) return same_side.push_back(offence);
    FaceTag tag = group.size() == 1 ? kHullFace : 0;
    if (triangle != nullptr) {
      const auto patch = std::lower_bound(patch_ref_.begin(), patch_ref_.end(), triangle->ref) - patch_ref_.begin();
      tag = static_cast<FaceTag>(tag | (patch + 1) | (triangle->required != 0 ? kRequiredFace : 0));
    } else if (group.size() == 1) {
      tag = static_cast<FaceTag>(tag | kBareHull);
      ++bare_hull;
    } else if (a.ref != b.ref) {
      tag = kBareRegion;
      ++bare_region;
    }
    for (const auto i : group) verdicts[i].tag = tag;
    verdicts[group.front()].speaks = tag != 0 ? 1 : 0;
  }

  const std::vector<Side>& sides_;
  std::vector<Triangle> triangles_;
  Triangle first_{};  ///< the first of those at the face that is judged
  const std::vector<std::int32_t>& patch_ref_;

 public:
  std::vector<Verdict> verdicts;
  std::vector<Offence> double_tets, crowded, same_side, stray_triangles, double_triangles;
  std::int64_t bare_hull = 0, bare_region = 0;
  std::int64_t tets_again = 0, triangles_again = 0;
};

std::vector<Triangle> send_triangles(const FileSource& src) {
  const auto& list = src.file.triangles;
  std::vector<Triangle> out(list.verts.size());
  std::vector<Rank> dest(out.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto key = face_key(list.verts[i][0], list.verts[i][1], list.verts[i][2]);
    out[i] = {key.gid, list.first + static_cast<std::int64_t>(i), list.ref[i], src.triangle_required[i]};
    dest[i] = meeting_rank(key.gid, src.comm.size());
  }
  return exchange_items(src.comm, dest, out).items;
}

/// Adds the patches of faces without triangle and puts their numbers where they were left open.
/// Gives the patch of hull faces without triangle, or -1.
int name_bare_patches(const FileSource& src, Court& court, std::vector<std::int32_t>& patch_ref,
                      DistributeReport& report) {
  report.untagged_hull_faces = src.comm.sum(court.bare_hull);
  report.untagged_region_faces = src.comm.sum(court.bare_region);
  std::int64_t next = patch_ref.empty() ? 1 : std::max<std::int64_t>(0, patch_ref.back()) + 1;
  const auto add = [&](std::int64_t faces) {
    if (faces == 0) return FaceTag{0};
    patch_ref.push_back(
        static_cast<std::int32_t>(std::min<std::int64_t>(next++, std::numeric_limits<std::int32_t>::max())));
    return static_cast<FaceTag>(patch_ref.size());
  };
  const FaceTag hull = add(report.untagged_hull_faces), region = add(report.untagged_region_faces);
  for (auto& v : court.verdicts) {
    const FaceTag patch = v.tag & kPatchMask;
    if (patch == kBareHull) v.tag = static_cast<FaceTag>((v.tag & ~kPatchMask) | hull);
    if (patch == kBareRegion) v.tag = static_cast<FaceTag>((v.tag & ~kPatchMask) | region);
  }
  return tag_patch(hull);
}

/// Collective. True when there are tetrahedra given again: then they are marked.
bool mark_copies(FileSource& src, const Growing& g, const std::vector<FaceId>& faces, const Inquiry<Side>& inquiry,
                 const Court& court) {
  if (src.comm.sum(court.tets_again) == 0) return false;
  const auto verdicts = inquiry.answer(court.verdicts);
  const auto& file = src.file.tets;
  const Blocks blocks(src.comm, file.first);
  std::vector<std::int64_t> numbers;
  std::vector<Rank> dest;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (verdicts[i].again == 0) continue;
    numbers.push_back(g.tet_number[face_tet(faces[i])]);
    dest.push_back(blocks.owner(numbers.back()));
  }
  src.tet_dropped.resize(file.verts.size(), 0);
  for (const std::int64_t n : exchange_items(src.comm, dest, numbers).items) src.tet_dropped[n - file.first] = 1;
  return true;
}

}  // namespace

bool match_and_tag_faces(FileSource& src, Growing& g, DistributeReport& report) {
  TetMesh& m = g.dist.mesh;
  match_locally(m);
  const auto faces = faces_to_judge(g);
  std::vector<Side> sides(faces.size());
  std::vector<Rank> dest(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const TetId t = face_tet(faces[i]);
    const FaceKey key = face_key(m, g.dist.vert2gid, faces[i]);
    const VertId opposite = m.tet2vert[t][face_side(faces[i])];
    sides[i] = {key.gid, g.dist.vert2gid[opposite], g.tet_number[t], m.tet_ref[t], key.odd ? 1 : 0};
    dest[i] = meeting_rank(key.gid, src.comm.size());
  }
  const Inquiry<Side> inquiry(src.comm, dest, sides);
  m.patch_ref = collect_patches(src);
  Court court(inquiry.asked().items, send_triangles(src), m.patch_ref);
  court.judge();
  refuse(src, court.double_tets, "tetrahedra given twice with different references", "remove one of each pair");
  report.double_tets += src.comm.sum(court.tets_again);
  if (mark_copies(src, g, faces, inquiry, court)) return false;
  refuse(src, court.crowded, "faces with more than two tetrahedra", "remove the tetrahedra that are too many");
  refuse(src, court.same_side, "faces with both tetrahedra on one side", "the mesh is tangled there: repair it");
  refuse(src, court.stray_triangles, "triangles that are no face of a tetrahedron",
         "remove them or add the tetrahedra");
  refuse(src, court.double_triangles, "triangles given twice with different references", "remove one of each pair");
  report.double_triangles = src.comm.sum(court.triangles_again);
  auto patch_ref = m.patch_ref;
  g.bare_hull_patch = name_bare_patches(src, court, patch_ref, report);
  m.patch_ref = std::move(patch_ref);
  const auto verdicts = inquiry.answer(court.verdicts);
  m.face_tag.assign(m.tet_slots(), {0, 0, 0, 0});
  for (std::size_t i = 0; i < faces.size(); ++i) {
    m.tag(faces[i]) = verdicts[i].tag;
    if (verdicts[i].speaks != 0) g.speakers.push_back(faces[i]);
    if (verdicts[i].tag == 0) continue;
    const VertClass flags = (verdicts[i].tag & kRequiredFace) != 0 ? kSurface | kRidge | kFixed : kSurface;
    for (const VertId v : m.verts(faces[i])) m.vert_class[v] |= flags;
  }
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.has(t, kRequiredTet)) continue;
    for (const VertId v : m.tet2vert[t]) m.vert_class[v] |= kRidge | kFixed;
  }
  return true;
}

}  // namespace skein::distributing
