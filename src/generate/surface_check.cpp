// Check and repair of a surface triangulation.
#include "generate/surface_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "base/error.hpp"
#include "generate/components.hpp"

namespace skein {
namespace {

using Triangle = std::array<GlobalId, 3>;

[[noreturn]] void refuse(const MeshSlice& mesh, const std::string& what) {
  throw Error(ExitCode::kInvalidMesh, fmt::format("{}: {}", mesh.path.empty() ? "surface" : mesh.path, what));
}

std::string and_more(std::size_t n) { return n > 1 ? fmt::format(" ({} in all)", n) : std::string(); }

/// The lowest vertex with the same coordinates, for every vertex.
std::vector<GlobalId> find_twins(const std::vector<Vec3>& coords) {
  std::vector<std::size_t> order(coords.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto less = [&](std::size_t a, std::size_t b) {
    const Vec3 p = coords[a], q = coords[b];
    return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<GlobalId> twin(coords.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && coords[order[i]] == coords[order[i - 1]];
    twin[order[i]] = same ? twin[order[i - 1]] : to_id<GlobalId>(order[i]);
  }
  return twin;
}

void check_triangles(const MeshSlice& mesh, const std::vector<GlobalId>& twin) {
  const auto& triangles = mesh.triangles.verts;
  for (std::size_t v = 0; v < mesh.coords.size(); ++v) {
    if (!is_finite(mesh.coords[v])) refuse(mesh, fmt::format("vertex {} has a coordinate that is not finite", v + 1));
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& v = triangles[t];
    const Vec3 a = mesh.coords[idx(v[0])], b = mesh.coords[idx(v[1])], c = mesh.coords[idx(v[2])];
    if (twin[idx(v[0])] == twin[idx(v[1])] || twin[idx(v[1])] == twin[idx(v[2])] ||
        twin[idx(v[2])] == twin[idx(v[0])]) {
      refuse(mesh, fmt::format("triangle {} has two corners at the same point; remove it", t + 1));
    }
    const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
    if (!(norm(cross(b - a, c - a)) > 1e-14 * longest)) {
      refuse(mesh, fmt::format("triangle {} (vertices {} {} {}) has no area; remove it", t + 1, num(v[0]) + 1,
                               num(v[1]) + 1, num(v[2]) + 1));
    }
  }
}

void check_duplicates(const MeshSlice& mesh) {
  struct Key {
    Triangle v;
    std::size_t number;
  };
  std::vector<Key> keys;
  keys.reserve(mesh.triangles.verts.size());
  for (Triangle v : mesh.triangles.verts) {
    std::sort(v.begin(), v.end());
    keys.push_back({v, keys.size()});
  }
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return std::tie(a.v, a.number) < std::tie(b.v, b.number); });
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].v == keys[i - 1].v) {
      refuse(mesh, fmt::format("triangles {} and {} have the same vertices; remove one", keys[i - 1].number + 1,
                               keys[i].number + 1));
    }
  }
}

/// Renumbers everything to the vertices that triangles use, each place once. Lists that name dropped vertices lose
/// them.
void drop_vertices(MeshSlice& mesh, const std::vector<GlobalId>& twin, ClosedSurface& result) {
  std::vector<GlobalId> old2new(mesh.coords.size(), kNoGlobal);
  for (Triangle& t : mesh.triangles.verts) {
    for (GlobalId& v : t) {
      v = twin[idx(v)];
      old2new[idx(v)] = GlobalId{0};
    }
  }
  std::int64_t n = 0;
  for (std::size_t v = 0; v < old2new.size(); ++v) {
    if (old2new[v] == kNoGlobal) {
      ++(twin[v] == to_id<GlobalId>(v) ? result.unused_verts : result.merged_verts);
      continue;
    }
    mesh.coords[n] = mesh.coords[v];
    mesh.vert_ref[n] = mesh.vert_ref[v];
    old2new[v] = GlobalId{n++};
  }
  mesh.total_verts = n;
  mesh.coords.resize(static_cast<std::size_t>(n));
  mesh.vert_ref.resize(static_cast<std::size_t>(n));
  const auto renumber = [&](GlobalId& v) { v = old2new[idx(twin[idx(v)])]; };
  for (Triangle& t : mesh.triangles.verts) std::for_each(t.begin(), t.end(), renumber);
  for (auto& e : mesh.edges.verts) std::for_each(e.begin(), e.end(), renumber);
  for (VertexListSlice* list : {&mesh.corners, &mesh.required_verts}) {
    std::for_each(list->verts.begin(), list->verts.end(), renumber);
    std::sort(list->verts.begin(), list->verts.end());
    list->verts.erase(std::unique(list->verts.begin(), list->verts.end()), list->verts.end());
    std::erase(list->verts, kNoGlobal);
    list->total = static_cast<std::int64_t>(list->verts.size());
  }
}

/// Drops edges that lost a vertex, and their numbers in the lists of ridges and required edges.
void drop_edges(MeshSlice& mesh) {
  std::vector<GlobalId> old2new(mesh.edges.verts.size(), kNoGlobal);
  std::size_t n = 0;
  for (std::size_t e = 0; e < old2new.size(); ++e) {
    const auto v = mesh.edges.verts[e];
    if (v[0] == kNoGlobal || v[1] == kNoGlobal || v[0] == v[1]) continue;
    mesh.edges.verts[n] = v;
    mesh.edges.ref[n] = mesh.edges.ref[e];
    old2new[e] = to_id<GlobalId>(n++);
  }
  mesh.edges.verts.resize(n);
  mesh.edges.ref.resize(n);
  mesh.edges.total = static_cast<std::int64_t>(n);
  for (VertexListSlice* list : {&mesh.ridges, &mesh.required_edges}) {
    for (GlobalId& e : list->verts) e = old2new[idx(e)];
    std::erase(list->verts, kNoGlobal);
    list->total = static_cast<std::int64_t>(list->verts.size());
  }
}

/// A side of a triangle: corners `side` and `side + 1`; the same edge lies side by side after sorting.
struct Side {
  GlobalId low, high;
  std::int64_t triangle;
  bool forward;  ///< the triangle runs from low to high
};

std::vector<Side> sorted_sides(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const GlobalId a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int64_t>(t), a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

/// Throws unless every edge has exactly two triangles. `number` gives the vertices' numbers in the file.
void check_closed(const MeshSlice& mesh, const std::vector<Side>& sides, const std::vector<GlobalId>& number) {
  std::size_t open = 0, crowded = 0;
  const Side *first_open = nullptr, *first_crowded = nullptr;
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    if (end - i == 1 && open++ == 0) first_open = &sides[i];
    if (end - i > 2 && crowded++ == 0) first_crowded = &sides[i];
  }
  const auto name = [&](const Side& s) {
    return fmt::format("vertices {} and {}", num(number[idx(s.low)]) + 1, num(number[idx(s.high)]) + 1);
  };
  if (first_open != nullptr) {
    refuse(mesh, fmt::format("the surface is not closed: the edge between {} has triangle {} only{}; close the surface",
                             name(*first_open), first_open->triangle + 1, and_more(open)));
  }
  if (first_crowded != nullptr) {
    refuse(mesh, fmt::format("the edge between {} has triangles {}, {} and {}{}; an edge must have two",
                             name(*first_crowded), first_crowded[0].triangle + 1, first_crowded[1].triangle + 1,
                             first_crowded[2].triangle + 1, and_more(crowded)));
  }
}

/// The triangles in shells, turned so that neighbours agree. `turned[t]` tells whether triangle t was turned.
Shells walk_shells(const MeshSlice& mesh, const std::vector<Side>& sides, std::vector<std::uint8_t>& turned) {
  struct Neighbour {
    std::int64_t triangle;
    bool agrees;
  };
  const auto& triangles = mesh.triangles.verts;
  std::vector<std::array<Neighbour, 3>> neighbour(triangles.size());
  std::vector<std::uint8_t> filled(triangles.size(), 0);
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    const Side &a = sides[i], &b = sides[i + 1];
    const bool agrees = a.forward != b.forward;
    neighbour[a.triangle][filled[a.triangle]++] = {b.triangle, agrees};
    neighbour[b.triangle][filled[b.triangle]++] = {a.triangle, agrees};
  }
  Shells shells;
  std::vector<std::uint8_t> seen(triangles.size(), 0);
  turned.assign(triangles.size(), 0);
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (seen[start]) continue;
    std::vector<std::size_t> shell{start};
    seen[start] = 1;
    for (std::size_t i = 0; i < shell.size(); ++i) {
      for (const Neighbour& next : neighbour[shell[i]]) {
        const auto t = static_cast<std::size_t>(next.triangle);
        const std::uint8_t wanted = next.agrees ? turned[shell[i]] : 1 - turned[shell[i]];
        if (seen[t] && turned[t] != wanted) refuse(mesh, fmt::format("the surface is one-sided at triangle {}", t + 1));
        if (seen[t]) continue;
        seen[t] = 1;
        turned[t] = wanted;
        shell.push_back(t);
      }
    }
    shells.number.push_back(std::move(shell));
  }
  return shells;
}

/// Volume inside a shell, positive when oriented outwards. Taken about a point of the shell, against cancellation.
double shell_volume(const std::vector<Vec3>& coords, const std::vector<Triangle>& triangles) {
  const Vec3 o = coords[idx(triangles.front()[0])];
  double sum = 0;
  for (const Triangle& t : triangles) {
    sum += dot(coords[idx(t[0])] - o, cross(coords[idx(t[1])] - o, coords[idx(t[2])] - o));
  }
  return sum / 6;
}

void orient(ClosedSurface& surface, const std::vector<Side>& sides) {
  MeshSlice& mesh = surface.mesh;
  std::vector<std::uint8_t> turned;
  Shells shells = walk_shells(mesh, sides, turned);
  std::vector<double> volume;
  for (const auto& shell : shells.number) {
    auto& triangles = shells.triangles.emplace_back();
    for (const std::size_t t : shell) {
      triangles.push_back(mesh.triangles.verts[t]);
      if (turned[t]) std::swap(triangles.back()[1], triangles.back()[2]);
    }
    volume.push_back(shell_volume(mesh.coords, triangles));
    if (volume.back() >= 0) continue;
    volume.back() = -volume.back();
    for (Triangle& t : triangles) std::swap(t[1], t[2]);
  }
  find_depths(mesh.coords, shells);
  surface.voids = find_voids(mesh.coords, shells);
  surface.shells = static_cast<int>(shells.number.size());
  for (std::size_t i = 0; i < shells.number.size(); ++i) {
    const bool is_void = shells.depth[i] % 2 == 1;
    surface.volume += is_void ? -volume[i] : volume[i];
    for (std::size_t k = 0; k < shells.number[i].size(); ++k) {
      Triangle t = shells.triangles[i][k];
      if (is_void) std::swap(t[1], t[2]);
      // the same cyclic order as before is no turn
      Triangle& old = mesh.triangles.verts[shells.number[i][k]];
      const Triangle next{old[1], old[2], old[0]}, last{old[2], old[0], old[1]};
      if (t == old || t == next || t == last) continue;
      ++surface.turned_triangles;
      old = t;
    }
  }
}

}  // namespace

ClosedSurface check_surface(MeshSlice whole) {
  ClosedSurface surface;
  surface.mesh = std::move(whole);
  MeshSlice& mesh = surface.mesh;
  mesh.tets = {};
  if (mesh.triangles.verts.empty()) refuse(mesh, "there are no triangles; volume generation needs a closed surface");
  const std::vector<GlobalId> twin = find_twins(mesh.coords);
  check_triangles(mesh, twin);
  std::vector<std::uint8_t> used(mesh.coords.size(), 0);
  for (const Triangle& t : mesh.triangles.verts) {
    for (const GlobalId v : t) used[idx(twin[idx(v)])] = 1;
  }
  std::vector<GlobalId> number;  // new vertex -> its number in the file, for messages
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v]) number.push_back(to_id<GlobalId>(v));
  }
  drop_vertices(mesh, twin, surface);
  drop_edges(mesh);
  check_duplicates(mesh);
  const std::vector<Side> sides = sorted_sides(mesh.triangles.verts);
  check_closed(mesh, sides, number);
  orient(surface, sides);
  return surface;
}

}  // namespace skein
