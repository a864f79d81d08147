// Validity of a mesh file. Faces, hull edges and equal vertices meet at rendezvous ranks, by a hash of what they are.
#include "report/check.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "comm/exchange.hpp"
#include "dist/blocks.hpp"
#include "dist/rendezvous.hpp"
#include "mesh/tet_mesh.hpp"
#include "report/check_hull.hpp"
#include "report/slice_coordinates.hpp"

namespace skein {
namespace {

/// Faces in one batch on a rank, at most about; bounds the memory.
constexpr std::int64_t kBatchFaces = 4'000'000;

bool before(const Finding& a, const Finding& b) noexcept {
  if (a.fault != b.fault) return a.fault < b.fault;
  if (a.entity != b.entity) return a.entity < b.entity;
  if (a.other != b.other) return a.other < b.other;
  return a.verts < b.verts;
}

/// Counts all, keeps the first few of each kind.
class Findings {
 public:
  void add(const Finding& f, std::int64_t times = 1) {
    const auto k = static_cast<std::size_t>(f.fault);
    counts[k] += times;
    first_[k].push_back(f);
    if (first_[k].size() >= 8 * kMaxFindings) trim(first_[k]);
  }
  /// Collective. The counts and the first few of all ranks, the same on every rank.
  void merge(const Comm& comm, CheckResult& result) {
    comm.reduce(std::span<std::int64_t>(counts), Op::kSum);
    result.counts = counts;
    for (auto& kind : first_) {
      trim(kind);
      std::vector<Finding> all = comm.all_gather(kind);
      trim(all);
      result.findings.insert(result.findings.end(), all.begin(), all.end());
    }
  }
  [[nodiscard]] std::int64_t count(Fault f) const noexcept { return counts[static_cast<std::size_t>(f)]; }
  std::array<std::int64_t, kFaults> counts{};

 private:
  static void trim(std::vector<Finding>& list) {
    std::sort(list.begin(), list.end(), before);
    if (list.size() > kMaxFindings) list.resize(kMaxFindings);
  }
  std::array<std::vector<Finding>, kFaults> first_;
};

template <std::size_t N>
Finding finding(Fault fault, const std::array<GlobalId, N>& verts, std::int64_t entity = -1, std::int64_t other = -1) {
  Finding f;
  f.fault = fault, f.entity = entity, f.other = other;
  f.corners = static_cast<std::int32_t>(N);
  std::copy(verts.begin(), verts.end(), f.verts.begin());
  return f;
}

/// A face of a tetrahedron, or a triangle (opposite == kNoGlobal, so that triangles come first).
struct Face {
  std::array<GlobalId, 3> key;  // ascending
  GlobalId opposite;
  std::int64_t entity2;  // 2 * number + (1 if the order is an odd permutation of key)
};
bool by_key(const Face& a, const Face& b) noexcept {
  if (a.key != b.key) return a.key < b.key;
  return a.opposite != b.opposite ? a.opposite < b.opposite : a.entity2 < b.entity2;
}
Face make_face_record(std::array<GlobalId, 3> v, GlobalId opposite, std::int64_t entity) noexcept {
  bool odd = false;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (v[i] > v[j]) std::swap(v[i], v[j]), odd = !odd;
  };
  order(0, 1), order(1, 2), order(0, 1);
  return {v, opposite, 2 * entity + (odd ? 1 : 0)};
}

struct Edge {
  GlobalId a, b;  // a < b
  friend auto operator<=>(const Edge&, const Edge&) = default;
};
void add_edges(const std::array<GlobalId, 3>& face, std::vector<Edge>& edges) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [a, b] = std::minmax(face[i], face[(i + 1) % 3]);
    edges.push_back({a, b});
  }
}

/// All records of one face: its triangles [first, tets), its tetrahedra [tets, last).
void judge_face(const Face* first, const Face* tets, const Face* last, Findings& found, CheckResult& r,
                std::vector<Edge>& hull_edges, std::vector<LoneFace>& hull) {
  const auto& key = first->key;
  const auto triangles = tets - first, count = last - tets;
  for (const Face* f = first; f < tets; ++f) {
    if (count == 0) found.add(finding(Fault::kTriangleNotFace, key, f->entity2 / 2));
    if (f > first) found.add(finding(Fault::kDuplicateTriangle, key, f->entity2 / 2, first->entity2 / 2));
  }
  for (const Face* f = tets + 1; f < last; ++f) {
    // each of its four faces would tell: let the one opposite to the highest vertex do it
    if (f->opposite == f[-1].opposite && f->opposite > key[2]) {
      const std::array<GlobalId, 4> v{key[0], key[1], key[2], f->opposite};
      found.add(finding(Fault::kDuplicateTet, v, f->entity2 / 2, f[-1].entity2 / 2));
    }
  }
  if (count == 1) {
    ++r.hull_faces;
    if (triangles == 0) found.add(finding(Fault::kHullFaceNotTriangle, key, tets->entity2 / 2));
    add_edges(key, hull_edges);
    hull.push_back({{key[0], key[1], key[2], tets->opposite}, tets->entity2 / 2, tets->entity2 & 1, triangles});
    return;
  }
  if (count >= 2) r.internal_triangles += triangles;
  if (count > 2) found.add(finding(Fault::kFaceOver2, key, tets[0].entity2 / 2, tets[1].entity2 / 2));
  if (count == 2 && ((tets[0].entity2 ^ tets[1].entity2) & 1) == 0) {
    const auto [a, b] = std::minmax({tets[0].entity2 / 2, tets[1].entity2 / 2});
    found.add(finding(Fault::kMisorientedPair, key, a, b));
  }
}

/// Collective. Matches all faces and triangles; gives the edges of the hull faces that were judged here, and them.
std::vector<Edge> match_faces(const Comm& comm, const MeshSlice& mesh, Findings& found, CheckResult& r,
                              std::vector<LoneFace>& hull) {
  const auto mine = static_cast<std::int64_t>(4 * mesh.tets.verts.size() + mesh.triangles.verts.size());
  const auto batches = static_cast<std::uint64_t>(comm.max(mine) / kBatchFaces + 1);
  const auto ranks = static_cast<std::uint64_t>(comm.size());
  std::vector<Edge> hull_edges;
  std::vector<Face> send;
  std::vector<Rank> dest;
  for (std::uint64_t batch = 0; batch < batches; ++batch) {
    send.clear(), dest.clear();
    const auto put = [&](const std::array<GlobalId, 3>& v, GlobalId opposite, std::int64_t entity) {
      const Face f = make_face_record(v, opposite, entity);
      const std::uint64_t h = hash_of(f.key);
      if (h / ranks % batches != batch) return;
      send.push_back(f);
      dest.push_back(meeting_rank(h, comm.size()));
    };
    for (std::size_t t = 0; t < mesh.tets.verts.size(); ++t) {
      const auto& v = mesh.tets.verts[t];
      for (std::size_t f = 0; f < 4; ++f) {
        const auto& k = kFaceVerts[f];
        put({v[k[0]], v[k[1]], v[k[2]]}, v[f], mesh.tets.first + static_cast<std::int64_t>(t));
      }
    }
    for (std::size_t t = 0; t < mesh.triangles.verts.size(); ++t) {
      put(mesh.triangles.verts[t], kNoGlobal, mesh.triangles.first + static_cast<std::int64_t>(t));
    }
    auto faces = exchange(comm, std::span<const Rank>(dest), std::span<const Face>(send)).items;
    std::sort(faces.begin(), faces.end(), by_key);
    const Face* end = faces.data() + faces.size();
    for (const Face* first = faces.data(); first < end;) {
      const Face* last = first;
      while (last < end && last->key == first->key) ++last;
      const Face* tets = std::find_if(first, last, [](const Face& f) { return f.opposite != kNoGlobal; });
      judge_face(first, tets, last, found, r, hull_edges, hull);
      first = last;
    }
  }
  return hull_edges;
}

/// Collective. The triangles of a mesh without tetrahedra: duplicates; gives the edges, as match_faces does.
std::vector<Edge> match_surface(const Comm& comm, const MeshSlice& mesh, Findings& found) {
  std::vector<Face> send;
  std::vector<Rank> dest;
  for (std::size_t t = 0; t < mesh.triangles.verts.size(); ++t) {
    send.push_back(
        make_face_record(mesh.triangles.verts[t], kNoGlobal, mesh.triangles.first + static_cast<std::int64_t>(t)));
    dest.push_back(meeting_rank(hash_of(send.back().key), comm.size()));
  }
  auto faces = exchange(comm, std::span<const Rank>(dest), std::span<const Face>(send)).items;
  std::sort(faces.begin(), faces.end(), by_key);
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i > 0 && faces[i].key == faces[i - 1].key) {
      found.add(finding(Fault::kDuplicateTriangle, faces[i].key, faces[i].entity2 / 2, faces[i - 1].entity2 / 2));
    }
    add_edges(faces[i].key, edges);
  }
  return edges;
}

/// Collective. Open and non-manifold edges of the hull. Gives vertices minus edges of the hull.
std::int64_t judge_hull_edges(const Comm& comm, const MeshSlice& mesh, const std::vector<Edge>& mine, Findings& found) {
  std::vector<Rank> dest;
  for (const Edge& e : mine) dest.push_back(meeting_rank(hash_of(std::array{e.a, e.b}), comm.size()));
  auto edges = exchange(comm, std::span<const Rank>(dest), std::span<const Edge>(mine)).items;
  std::sort(edges.begin(), edges.end());
  std::int64_t distinct = 0;
  std::vector<GlobalId> ends;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j] == edges[i]) ++j;
    const std::array<GlobalId, 2> both{edges[i].a, edges[i].b};
    if ((j - i) % 2 == 1) found.add(finding(Fault::kOpenHullEdge, both));
    if (j - i > 2) found.add(finding(Fault::kNonmanifoldHullEdge, both));
    ++distinct;
    ends.insert(ends.end(), both.begin(), both.end());
    i = j;
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  dest.clear();
  const Blocks blocks(comm, mesh.first_vert);
  for (const GlobalId g : ends) dest.push_back(blocks.owner(num(g)));
  auto verts = exchange(comm, std::span<const Rank>(dest), std::span<const GlobalId>(ends)).items;
  std::sort(verts.begin(), verts.end());
  const auto n = std::unique(verts.begin(), verts.end()) - verts.begin();
  return comm.sum(static_cast<std::int64_t>(n) - distinct);
}

struct Point {
  Vec3 x;
  std::int64_t number;
};
/// Collective. Vertices with the same coordinates.
void judge_duplicate_vertices(const Comm& comm, const MeshSlice& mesh, Findings& found) {
  std::vector<Point> send;
  std::vector<Rank> dest;
  for (std::size_t i = 0; i < mesh.coords.size(); ++i) {
    if (!is_finite(mesh.coords[i])) continue;
    const Vec3 x = mesh.coords[i] + Vec3{};  // -0 becomes +0
    std::uint64_t h = 0;
    for (const double c : {x.x, x.y, x.z}) h = mix(h ^ std::bit_cast<std::uint64_t>(c));
    send.push_back({x, mesh.first_vert + static_cast<std::int64_t>(i)});
    dest.push_back(meeting_rank(h, comm.size()));
  }
  auto points = exchange(comm, std::span<const Rank>(dest), std::span<const Point>(send)).items;
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    if (a.x.x != b.x.x) return a.x.x < b.x.x;
    if (a.x.y != b.x.y) return a.x.y < b.x.y;
    return a.x.z != b.x.z ? a.x.z < b.x.z : a.number < b.number;
  });
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].x != points[i - 1].x) continue;
    const std::array<GlobalId, 1> v{to_id<GlobalId>(points[i].number)};
    found.add(finding(Fault::kDuplicateVertex, v, points[i].number, points[i - 1].number));
  }
}

/// The volume that the triangles of a closed surface enclose, and whether they are all oriented the same way: then an
/// edge is passed once in each direction. Both are sums over the triangles of all ranks.
struct Enclosure {
  double volume = 0;
  std::uint64_t turns = 0;  ///< hashes of the edges with the sign of their direction; 0: oriented
  void add(const std::array<GlobalId, 3>& v, Vec3 a, Vec3 b, Vec3 c) noexcept {
    volume += dot(a, cross(b, c)) / 6;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto from = static_cast<std::uint64_t>(num(v[i])), to = static_cast<std::uint64_t>(num(v[(i + 1) % 3]));
      const std::uint64_t edge = mix(mix(std::min(from, to)) ^ std::max(from, to));
      turns += from < to ? edge : 0 - edge;
    }
  }
};

/// Collective. Volumes, degenerate tetrahedra, unused vertices, area.
void judge_entities(const Comm& comm, const MeshSlice& mesh, Findings& found, CheckResult& r) {
  std::vector<char> used(mesh.coords.size(), 0);
  r.min_volume = std::numeric_limits<double>::infinity();
  {
    const SliceCoordinates x(comm, mesh, mesh.tets.verts, r.surface_only ? nullptr : &used);
    for (std::size_t t = 0; t < mesh.tets.verts.size(); ++t) {
      auto v = mesh.tets.verts[t];
      const auto number = mesh.tets.first + static_cast<std::int64_t>(t);
      const double volume = volume6(x[v[0]], x[v[1]], x[v[2]], x[v[3]]) / 6;
      r.volume += volume;
      r.min_volume = std::min(r.min_volume, volume);
      if (!(volume > 0)) found.add(finding(Fault::kNonpositiveTet, v, number));
      const auto as_given = v;
      std::sort(v.begin(), v.end());
      if (std::adjacent_find(v.begin(), v.end()) != v.end()) {
        found.add(finding(Fault::kDegenerateTet, as_given, number));
      }
    }
  }
  const SliceCoordinates x(comm, mesh, mesh.triangles.verts, r.surface_only ? &used : nullptr);
  Enclosure inside;
  for (const auto& v : mesh.triangles.verts) {
    r.area += norm(cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]])) / 2;
    inside.add(v, x[v[0]], x[v[1]], x[v[2]]);
  }
  r.oriented = comm.sum(inside.turns) == 0;
  if (r.surface_only) r.volume = inside.volume;
  for (std::size_t i = 0; i < mesh.coords.size(); ++i) {
    const auto number = mesh.first_vert + static_cast<std::int64_t>(i);
    const std::array<GlobalId, 1> v{to_id<GlobalId>(number)};
    if (used[i] == 0) found.add(finding(Fault::kUnusedVertex, v, number));
    const Vec3 p = mesh.coords[i];
    const int bad = !std::isfinite(p.x) + !std::isfinite(p.y) + !std::isfinite(p.z);
    if (bad > 0) found.add(finding(Fault::kNonfiniteCoordinate, v, number), bad);
  }
}

/// Collective. Fills in the coordinates of the findings: each rank those of its slice.
void locate(const Comm& comm, const MeshSlice& mesh, std::vector<Finding>& findings) {
  std::vector<double> x(findings.size() * 12, 0);
  const auto at = [&](std::size_t i, std::size_t c) { return (i * 4 + c) * 3; };
  for (std::size_t i = 0; i < findings.size(); ++i) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(findings[i].corners); ++c) {
      const std::int64_t own = num(findings[i].verts[c]) - mesh.first_vert;
      if (own < 0 || own >= static_cast<std::int64_t>(mesh.coords.size())) continue;
      const Vec3 p = mesh.coords[own];
      x[at(i, c)] = p.x, x[at(i, c) + 1] = p.y, x[at(i, c) + 2] = p.z;
    }
  }
  comm.reduce(std::span<double>(x), Op::kSum);
  for (std::size_t i = 0; i < findings.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) findings[i].coords[c] = {x[at(i, c)], x[at(i, c) + 1], x[at(i, c) + 2]};
  }
}

/// A mesh without any triangles is complete: its hull is a patch.
bool is_warning(Fault fault, const CheckResult& r) noexcept {
  return fault == Fault::kUnusedVertex || fault == Fault::kDuplicateVertex ||
         (fault == Fault::kNonmanifoldHullEdge && !r.surface_only) ||
         (fault == Fault::kHullFaceNotTriangle && r.triangles == 0);
}

}  // namespace

CheckResult check_mesh(const Comm& comm, const MeshSlice& mesh) {
  CheckResult r;
  r.vertices = mesh.total_verts, r.tets = mesh.tets.total, r.triangles = mesh.triangles.total;
  r.surface_only = r.tets == 0 && r.triangles > 0;
  Findings found;
  judge_entities(comm, mesh, found, r);
  judge_duplicate_vertices(comm, mesh, found);
  std::vector<LoneFace> hull;
  const std::vector<Edge> edges =
      r.surface_only ? match_surface(comm, mesh, found) : match_faces(comm, mesh, found, r, hull);
  const std::int64_t verts_minus_edges = judge_hull_edges(comm, mesh, edges, found);
  if (!r.surface_only && comm.sum(found.count(Fault::kNonfiniteCoordinate)) == 0) {
    const bool oriented = comm.sum(found.count(Fault::kNonpositiveTet) + found.count(Fault::kMisorientedPair)) == 0;
    for (const Finding& f : hull_findings(comm, mesh, hull, oriented ? Nesting::kJudge : Nesting::kIgnore, r))
      found.add(f);
  }
  found.merge(comm, r);
  locate(comm, mesh, r.findings);

  r.hull_faces = r.surface_only ? r.triangles : comm.sum(r.hull_faces);
  r.internal_triangles = comm.sum(r.internal_triangles);
  r.hull_euler = verts_minus_edges + r.hull_faces;
  r.volume = comm.sum(r.volume);
  if (r.surface_only)
    r.volume = r.oriented && r.counts[static_cast<std::size_t>(Fault::kOpenHullEdge)] == 0 ? std::abs(r.volume) : 0;
  r.area = comm.sum(r.area);
  r.min_volume = r.tets > 0 ? comm.min(r.min_volume) : 0;
  r.valid = r.tets > 0 || r.surface_only;
  for (std::size_t f = 0; f < kFaults; ++f) {
    if (r.counts[f] > 0 && !is_warning(static_cast<Fault>(f), r)) r.valid = false;
  }
  return r;
}

}  // namespace skein
