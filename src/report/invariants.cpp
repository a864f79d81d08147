// The sums that the end check compares.
#include "report/invariants.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "base/hash.hpp"
#include "comm/halo.hpp"
#include "dist/gather_slices.hpp"
#include "dist/sharing.hpp"
#include "mesh/predicates.hpp"
#include "report/shapes.hpp"

namespace skein {
namespace {

std::uint64_t hash_of(Vec3 x) noexcept {
  std::uint64_t h = 0;
  for (const double c : {x.x, x.y, x.z}) h = mix(h ^ std::bit_cast<std::uint64_t>(c + 0.0));  // -0 is 0
  return h;
}
/// Of a set of vertices: their order does not matter.
template <class Verts>
std::uint64_t hash_of(const TetMesh& m, const Verts& verts, std::int32_t ref) noexcept {
  std::uint64_t sum = 0;
  for (const VertId v : verts) sum += hash_of(m.coords[v]);
  return mix_pair(sum, static_cast<std::uint32_t>(ref));
}
void add(Roll& roll, std::uint64_t hash) noexcept { ++roll.count, roll.hash += hash; }

/// The faces and edges that this rank speaks for; over all ranks each is there once.
struct Spoken {
  std::vector<FaceId> faces;
  std::vector<FeatureEdge> edges;
};

void call_rolls(const Comm& comm, const DistMesh& dist, const Spoken& mine, Invariants& out) {
  const TetMesh& m = dist.mesh;
  const auto owned = owned_verts(comm, dist);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (owned[v] == 0) continue;
    if (m.has(v, kCorner)) add(out.corners, hash_of(m.coords[v]));
    if (m.has(v, kRequired)) add(out.required_verts, hash_of(m.coords[v]));
  }
  for (const FaceId f : mine.faces) {
    const FaceTag tag = m.tag(f);
    if ((tag & kRequiredFace) != 0) add(out.required_triangles, hash_of(m, m.verts(f), m.patch_ref[tag_patch(tag)]));
  }
  for (const FeatureEdge& e : mine.edges) {
    if (e.has(kRequiredEdge)) add(out.required_edges, hash_of(m, std::array{e.a, e.b}, e.ref));
  }
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (m.has(t, kRequiredTet)) add(out.required_tets, hash_of(m, m.tet2vert[t], m.tet_ref[t]));
  }
  std::vector<std::uint64_t> sums;
  const std::array rolls{&out.corners, &out.required_verts, &out.required_edges, &out.required_triangles,
                         &out.required_tets};
  for (const Roll* r : rolls) sums.insert(sums.end(), {r->count, r->hash});
  comm.reduce(std::span<std::uint64_t>(sums), Op::kSum);
  for (std::size_t i = 0; i < rolls.size(); ++i) *rolls[i] = {sums[2 * i], sums[2 * i + 1]};
}

/// Collective. For each key that any rank has one entry, ascending.
std::vector<Extent> make_extents(const Comm& comm, std::vector<std::int64_t> keys) {
  const auto once = [](std::vector<std::int64_t>& k) {
    std::sort(k.begin(), k.end());
    k.erase(std::unique(k.begin(), k.end()), k.end());
  };
  once(keys);
  keys = comm.all_gather(keys);
  once(keys);
  std::vector<Extent> out;
  for (const std::int64_t k : keys) out.push_back({k, 0, 0});
  return out;
}
Extent& at(std::vector<Extent>& list, std::int64_t key) {
  return *std::lower_bound(list.begin(), list.end(), key, [](const Extent& e, std::int64_t k) { return e.key < k; });
}
/// Collective. Adds up the values, and takes the flags of all ranks.
void add_ranks(const Comm& comm, std::vector<Extent>& list) {
  std::vector<double> value, curved;
  for (const Extent& e : list) value.push_back(e.value), curved.push_back(e.curved);
  comm.reduce(std::span<double>(value), Op::kSum);
  comm.reduce(std::span<double>(curved), Op::kMax);
  for (std::size_t i = 0; i < list.size(); ++i) list[i].value = value[i], list[i].curved = curved[i];
}

/// Collective. Nonzero where a line bends at a vertex that may go.
std::vector<char> bent_verts(const Comm& comm, const DistMesh& dist, const std::vector<FeatureEdge>& edges) {
  const TetMesh& m = dist.mesh;
  std::vector<double> sum(4 * m.vert_slots(), 0);  // of the directions of the edges at the vertex, and their number
  const auto count = [&](VertId v, Vec3 d) {
    double* const s = sum.data() + 4 * idx(v);
    s[0] += d.x, s[1] += d.y, s[2] += d.z, s[3] += 1;
  };
  for (const FeatureEdge& e : edges) {
    const Vec3 d = normalized(m.coords[e.b] - m.coords[e.a]);
    count(e.a, d), count(e.b, -1.0 * d);
  }
  Halo(comm, dist.sharing).sum(std::span<double>(sum), 4);
  std::vector<char> bent(m.vert_slots(), 0);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const double* const s = sum.data() + 4 * idx(v);
    if (s[3] == 0 || m.has(v, kStays)) continue;
    bent[idx(v)] = s[3] != 2 || norm({s[0], s[1], s[2]}) > kStraight ? 1 : 0;
  }
  return bent;
}

/// Collective. Lines and patches: their extents, and which are curved. `folded`: per patch, by its facets.
void measure_boundary(const Comm& comm, const DistMesh& dist, const Spoken& mine, const std::vector<double>& folded,
                      Invariants& out) {
  const TetMesh& m = dist.mesh;
  const std::vector<char> bent = bent_verts(comm, dist, mine.edges);
  std::vector<std::int64_t> keys;
  for (const FeatureEdge& e : mine.edges) keys.push_back(line_key(e));
  out.lines = make_extents(comm, std::move(keys));
  for (const FeatureEdge& e : mine.edges) {
    Extent& line = at(out.lines, line_key(e));
    line.value += norm(m.coords[e.b] - m.coords[e.a]);
    if (bent[idx(e.a)] != 0 || bent[idx(e.b)] != 0) line.curved = 1;
  }
  add_ranks(comm, out.lines);
  for (std::size_t p = 0; p < m.patch_ref.size(); ++p) out.patches.push_back({m.patch_ref[p], 0, folded[p]});
  for (const FaceId f : mine.faces) {
    const auto v = m.verts(f);
    Extent& patch = out.patches[static_cast<std::size_t>(tag_patch(m.tag(f)))];
    patch.value += 0.5 * norm(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
    for (const VertId w : v) patch.curved = std::max(patch.curved, bent[idx(w)] != 0 ? 1.0 : 0.0);
  }
  add_ranks(comm, out.patches);
}

/// Collective. The bounding box: its low corner and its diagonal.
struct Extremes {
  Vec3 low;
  double diagonal = 0;
};
Extremes extremes(const Comm& comm, const TetMesh& m) {
  std::array<double, 6> b;
  b.fill(std::numeric_limits<double>::max());
  for (const Vec3 x : m.coords) {
    const std::array<double, 6> p{x.x, x.y, x.z, -x.x, -x.y, -x.z};
    for (std::size_t i = 0; i < 6; ++i) b[i] = std::min(b[i], p[i]);
  }
  comm.reduce(std::span<double>(b), Op::kMin);
  return {{b[0], b[1], b[2]}, norm({b[0] + b[3], b[1] + b[4], b[2] + b[5]})};
}

/// Collective. Regions and what the hull encloses. @pre the patches are measured
void measure_volumes(const Comm& comm, const DistMesh& dist, Invariants& out) {
  const TetMesh& m = dist.mesh;
  const Extremes box = extremes(comm, m);
  std::vector<std::int64_t> keys;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (keys.empty() || keys.back() != m.tet_ref[t]) keys.push_back(m.tet_ref[t]);
  }
  out.regions = make_extents(comm, std::move(keys));
  Extent* region = nullptr;
  double enclosed = 0;
  std::int64_t nonpositive = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (region == nullptr || region->key != m.tet_ref[t]) region = &at(out.regions, m.tet_ref[t]);
    region->value += volume6(m, t) / 6;
    const auto& v = m.tet2vert[t];
    if (orient3d_sign(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]]) <= 0) ++nonpositive;
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceTag tag = m.face_tag[t][k];
      if (tag == 0) continue;
      region->curved = std::max(region->curved, out.patches[static_cast<std::size_t>(tag_patch(tag))].curved);
      if (!is_hull(tag)) continue;
      const auto f = m.verts(make_face(t, k));
      const Vec3 a = m.coords[f[0]] - box.low, b = m.coords[f[1]] - box.low, c = m.coords[f[2]] - box.low;
      enclosed += dot(a, cross(b, c)) / 6;
    }
  }
  add_ranks(comm, out.regions);
  out.hull_volume = comm.sum(enclosed);
  out.nonpositive_tets = comm.sum(nonpositive);
  for (const Extent& p : out.patches) out.size += box.diagonal * p.value;
}

}  // namespace

Invariants invariants(const Comm& comm, const DistMesh& dist) {
  Invariants out;
  const Spoken mine{faces_to_write(comm, dist), edges_to_write(comm, dist)};
  call_rolls(comm, dist, mine, out);
  ShapesFound found = find_shapes(comm, dist, mine.faces, mine.edges);
  out.shapes = std::move(found.shapes);
  measure_boundary(comm, dist, mine, found.folded, out);
  measure_volumes(comm, dist, out);
  return out;
}

}  // namespace skein
