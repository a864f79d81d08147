// Gathering the boundary.
#include "dist/reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <tuple>

#include "base/error.hpp"
#include "comm/halo.hpp"
#include "dist/gather_slices.hpp"

namespace skein {
namespace {

/// A ridge vertex that is so many times as far from the feature edges as from the patch is on the patch.
constexpr double kFarFromEdge = 4;

struct SentPoint {
  GlobalId gid;
  Vec3 x;
  std::int32_t corner;
};
struct SentTriangle {
  std::array<GlobalId, 3> gid;
  std::int32_t patch;
  BoundarySurface::Sides sides;
  double most;
};
struct SentEdge {
  std::array<GlobalId, 2> gid;
  std::int64_t key;
};

/// The lowest first, in the same sense of rotation.
std::array<GlobalId, 3> rotated(std::array<GlobalId, 3> g) {
  std::rotate(g.begin(), std::min_element(g.begin(), g.end()), g.end());
  return g;
}

/// Collective. Volume over area of each region.
std::map<std::int32_t, double> thickness(const Comm& comm, const TetMesh& m) {
  std::map<std::int32_t, std::pair<double, double>> here;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    auto& [volume, area] = here[m.tet_ref[t]];
    volume += volume6(m, t) / 6;
    for (std::size_t k = 0; k < 4; ++k) {
      if (m.face_tag[t][k] == 0) continue;
      const auto v = m.verts(make_face(t, k));
      area += 0.5 * norm(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
    }
  }
  struct Sent {
    std::int32_t ref;
    double volume, area;
  };
  std::vector<Sent> sent;
  for (const auto& [ref, sums] : here) sent.push_back({ref, sums.first, sums.second});
  here.clear();
  for (const Sent& s : comm.all_gather(sent)) here[s.ref].first += s.volume, here[s.ref].second += s.area;
  std::map<std::int32_t, double> out;
  for (const auto& [ref, sums] : here) out[ref] = sums.second > 0 ? sums.first / sums.second : 1e300;
  return out;
}

template <class T, class Key>
void sort_once(std::vector<T>& list, Key&& key) {
  std::sort(list.begin(), list.end(), [&](const T& a, const T& b) { return key(a) < key(b); });
  list.erase(std::unique(list.begin(), list.end(), [&](const T& a, const T& b) { return key(a) == key(b); }),
             list.end());
}

/// Index of a global id among the points.
std::int32_t index_of(const std::vector<GlobalId>& points, GlobalId gid) {
  const auto at = std::lower_bound(points.begin(), points.end(), gid);
  return at != points.end() && *at == gid ? static_cast<std::int32_t>(at - points.begin()) : -1;
}

std::vector<SentTriangle> triangles_here(const Comm& comm, const DistMesh& dist, const DeviationLimits& limits) {
  const TetMesh& m = dist.mesh;
  const auto thick = thickness(comm, m);
  const auto allowed = [&](std::int32_t ref) {
    return limits.thickness_share > 0 ? limits.thickness_share * thick.at(ref) : 1e300;
  };
  std::vector<SentTriangle> out;
  for (const FaceId f : faces_to_write(comm, dist)) {
    const auto v = m.verts(f);
    const std::int32_t ref = m.tet_ref[face_tet(f)];
    SentTriangle s{rotated({dist.vert2gid[v[0]], dist.vert2gid[v[1]], dist.vert2gid[v[2]]}),
                   tag_patch(m.tag(f)),
                   {ref, 0, 0},
                   allowed(ref)};
    if (const FaceId other = m.neighbour(f); other != kNoFace) {
      s.sides.before = m.tet_ref[face_tet(other)];
      s.sides.has_before = 1;
      s.most = std::min(s.most, allowed(s.sides.before));
    }
    out.push_back(s);
  }
  return out;
}

/// The sides of the triangles, ends ascending.
std::vector<std::array<GlobalId, 2>> sides_of(const std::vector<SentTriangle>& triangles) {
  std::vector<std::array<GlobalId, 2>> out;
  for (const SentTriangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(t.gid[i], t.gid[(i + 1) % 3]);
      out.push_back({a, b});
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

BoundarySurface gather_boundary(const Comm& comm, const DistMesh& dist, const DeviationLimits& limits) {
  const TetMesh& m = dist.mesh;
  std::vector<SentPoint> points;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (m.has(v, kSurface)) points.push_back({dist.vert2gid[v], m.coords[v], m.has(v, kCorner) ? 1 : 0});
  }
  std::vector<SentEdge> edges;
  for (const FeatureEdge& e : edges_to_write(comm, dist)) {
    const auto [a, b] = std::minmax(dist.vert2gid[e.a], dist.vert2gid[e.b]);
    edges.push_back({{a, b}, std::int64_t{e.ref} * 256 + static_cast<int>(e.edge_class)});
  }
  points = comm.all_gather(points);
  edges = comm.all_gather(edges);
  std::vector<SentTriangle> triangles = comm.all_gather(triangles_here(comm, dist, limits));
  sort_once(points, [](const SentPoint& p) { return p.gid; });
  sort_once(edges, [](const SentEdge& e) { return e.gid; });
  sort_once(triangles, [](const SentTriangle& t) { return t.gid; });

  BoundarySurface out;
  for (const SentPoint& p : points) {
    out.points.push_back(p.gid);
    out.input.points.push_back(p.x);
    out.input.is_corner.push_back(static_cast<std::uint8_t>(p.corner));
  }
  const auto index = [&](GlobalId g) { return index_of(out.points, g); };
  for (const SentTriangle& t : triangles) {
    out.input.triangles.push_back({index(t.gid[0]), index(t.gid[1]), index(t.gid[2])});
    out.input.patch.push_back(t.patch);
    out.sides.push_back(t.sides);
    out.most.push_back(t.most);
  }
  const auto sides = sides_of(triangles);
  for (const SentEdge& e : edges) {
    if (!std::binary_search(sides.begin(), sides.end(), e.gid)) continue;
    out.input.edges.push_back({index(e.gid[0]), index(e.gid[1])});
    out.edge_key.push_back(e.key);
  }
  return out;
}

void place_on_own_surface(DistMesh& dist, const BoundarySurface& boundary, const ReferenceSurface& surface) {
  TetMesh& m = dist.mesh;
  m.surface_place.raw().assign(m.vert_slots(), SurfacePlace::kUnknown);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (!m.has(v, kSurface)) continue;
    const std::int32_t at = index_of(boundary.points, dist.vert2gid[v]);
    if (at >= 0) m.surface_place[v] = surface.place_of_point(at);
  }
}

void place_on_other_surface(const Comm& comm, DistMesh& dist, const ReferenceSurface& surface,
                            const std::vector<std::int32_t>& patch_ref) {
  TetMesh& m = dist.mesh;
  std::vector<std::int64_t> patch(m.vert_slots(), -1);  // of the surface, at a vertex
  agree(comm, [&] {
    std::vector<std::int64_t> same;  // patch here -> patch there
    for (const std::int32_t ref : m.patch_ref) {
      const auto at = std::find(patch_ref.begin(), patch_ref.end(), ref);
      same.push_back(at == patch_ref.end() ? -1 : at - patch_ref.begin());
    }
    for (const TetId t : IdRange<TetId>(m.tet_slots())) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (m.face_tag[t][k] == 0) continue;
        const auto at = static_cast<std::size_t>(tag_patch(m.face_tag[t][k]));
        if (same[at] < 0) {
          throw Error(ExitCode::kInput,
                      fmt::format("the geometry mesh has no triangles of reference {}, which the mesh "
                                  "has; both need the same patches",
                                  m.patch_ref[at]));
        }
        for (const VertId v : m.verts(make_face(t, k))) patch[idx(v)] = std::max(patch[idx(v)], same[at]);
      }
    }
  });
  Halo(comm, dist.sharing).max(std::span<std::int64_t>(patch));
  agree(comm, [&] {
    m.surface_place.raw().assign(m.vert_slots(), SurfacePlace::kUnknown);
    for (const VertId v : IdRange<VertId>(m.vert_slots())) {
      if (patch[idx(v)] < 0 || m.has(v, kCorner)) continue;
      const Vec3 x = m.coords[v];
      const auto there = static_cast<std::int32_t>(patch[idx(v)]);
      const SurfacePoint on = surface.nearest_of_patch(x, there);
      m.surface_place[v] = on.place;
      if (!m.has(v, kRidge)) continue;
      // A fold of the mesh may be no feature of the geometry.
      const SurfacePoint edge = surface.nearest_on_edges(x, SurfacePlace::kUnknown);
      if (norm(edge.x - x) <= kFarFromEdge * (norm(on.x - x) + surface.allowed_deviation(on.place)))
        m.surface_place[v] = edge.place;
    }
  });
}

}  // namespace skein
