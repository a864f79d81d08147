// Meshes for tests of one part.
#include "tests/support/tet_meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/adjacency.hpp"
#include "mesh/predicates.hpp"
#include "tests/support/whole_mesh.hpp"

namespace skein::test {
namespace {

Vec3 bend(Shape shape, Vec3 x) {
  switch (shape) {
    case Shape::kBox:
      return x;
    case Shape::kSkewed:
      return {0.9 * x.x + 0.31 * x.y - 0.17 * x.z, 1.07 * x.y + 0.23 * x.z - 0.11 * x.x, 0.83 * x.z + 0.13 * x.x};
    case Shape::kCylinder: {
      const double r = 1 + x.x, angle = 1.2 * x.y;
      return {r * std::cos(angle), r * std::sin(angle), x.z};
    }
    case Shape::kSphere: {
      const double r = 1 + x.x;
      return r * normalized({1, std::tan(1.2 * (x.y - 0.5)), std::tan(1.2 * (x.z - 0.5))});
    }
  }
  return x;
}

/// The cells as a mesh without adjacency.
TetMesh mesh_of(const WholeMesh& cells) {
  TetMesh m;
  m.coords = IdVector<VertId, Vec3>(cells.coords);
  for (const auto& t : cells.tets) {
    m.tet2vert.push_back({to_id<VertId>(t[0]), to_id<VertId>(t[1]), to_id<VertId>(t[2]), to_id<VertId>(t[3])});
  }
  m.tet_ref = IdVector<TetId, std::int32_t>(cells.tet_ref);
  m.tet_class.assign(m.tet_slots(), TetClass{});
  return m;
}

void tag_faces(TetMesh& m, const MeshSpec& spec, std::mt19937& random) {
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t f = 0; f < 4; ++f) {
      const auto v = m.verts(make_face(t, f));
      const std::array x{m.coords[v[0]], m.coords[v[1]], m.coords[v[2]]};
      const int side = spec.two_regions && in_middle_plane(x) ? 6 : side_of_cube(x);
      if (side < 0) continue;
      FaceTag& tag = m.face_tag[t][f];
      if (tag != 0) continue;  // the other side came first
      tag = static_cast<FaceTag>(side + 1);
      if (spec.required && random() % 40 == 0) tag |= kRequiredFace;
      const FaceId other = m.tet2face[t][f];
      if (other == kNoFace) {
        tag |= kHullFace;
      } else {
        m.tag(other) = tag;
      }
    }
  }
}

/// Moves inner vertices at random, as far as their tetrahedra stay positive.
void perturb(TetMesh& m, double size, std::mt19937& random) {
  std::uniform_real_distribution<double> any(-size, size);
  IdVector<VertId, std::vector<TetId>> ball(m.vert_slots());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (const VertId v : m.tet2vert[t]) ball[v].push_back(t);
  }
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (m.has(v, kSurface)) continue;
    const Vec3 was = m.coords[v];
    m.coords[v] += {any(random), any(random), any(random)};
    for (const TetId t : ball[v]) {
      if (volume6(m, t) < 1e-3 * size * size * size) m.coords[v] = was;
    }
  }
}

/// Tagged faces round one edge.
struct EdgeFaces {
  int count = 0;
  FaceTag tag = 0;
  Vec3 normal;
  bool feature = false;
};
using Edge = std::array<VertId, 2>;

}  // namespace

void find_features(TetMesh& m) {
  std::map<Edge, EdgeFaces> edges;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f] & kPatchMask;
      const FaceId other = m.tet2face[t][f];
      if (tag == 0 || (other != kNoFace && other < make_face(t, f))) continue;
      const auto v = m.verts(make_face(t, f));
      const Vec3 n = normalized(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
      for (std::size_t i = 0; i < 3; ++i) {
        EdgeFaces& e = edges[{std::min(v[i], v[(i + 1) % 3]), std::max(v[i], v[(i + 1) % 3])}];
        if (++e.count == 1) {
          e.tag = tag;
          e.normal = n;
        } else if (e.count > 2 || e.tag != tag || std::abs(dot(n, e.normal)) < std::sqrt(0.5)) {
          e.feature = true;
        }
      }
    }
  }
  IdVector<VertId, std::vector<VertId>> along(m.vert_slots());
  for (const auto& [e, faces] : edges) {
    if (!faces.feature) continue;
    const Vec3 d = m.coords[e[1]] - m.coords[e[0]];
    const bool x = std::abs(d.x) > std::max(std::abs(d.y), std::abs(d.z)), y = std::abs(d.y) > std::abs(d.z);
    m.features.insert({e[0], e[1], x ? 1 : y ? 2 : 3, kRidgeEdge});
    along[e[0]].push_back(e[1]);
    along[e[1]].push_back(e[0]);
  }
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const auto& w = along[v];
    if (w.empty()) continue;
    const bool smooth =
        w.size() == 2 && dot(normalized(m.coords[w[0]] - m.coords[v]), normalized(m.coords[w[1]] - m.coords[v])) < -0.7;
    if (!smooth || m.features.find(v, w[0])->ref != m.features.find(v, w[1])->ref) m.vert_class[v] |= kCorner;
  }
}

TetMesh make_mesh(const MeshSpec& spec) {
  std::mt19937 random(spec.seed);
  TetMesh m = mesh_of(cells(spec.n));
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    double x = 0;
    for (const VertId v : m.tet2vert[t]) x += m.coords[v].x / 4;
    if (spec.two_regions && x > 0.5) m.tet_ref[t] = 2;
  }
  m.face_tag.assign(m.tet_slots(), {0, 0, 0, 0});
  m.vert_ref.assign(m.vert_slots(), 0);
  m.vert_class.assign(m.vert_slots(), {});
  m.vert_state.assign(m.vert_slots(), kActive);
  m.patch_ref = {11, 12, 13, 14, 15, 16, 17};
  build_adjacency(m);
  tag_faces(m, spec, random);
  mark_boundary_vertices(m);
  for (auto& x : m.coords) x = bend(spec.shape, x);
  if (spec.perturb > 0) perturb(m, spec.perturb / spec.n, random);
  find_features(m);
  mark_boundary_vertices(m);
  if (spec.required) {
    for (VertClass& c : m.vert_class) {
      if (random() % 40 == 0) c |= kRequired;
    }
  }
  return m;
}

TetMesh cut_out(const TetMesh& whole, const IdVector<TetId, int>& label, int b, IdVector<VertId, GlobalId>& gid) {
  TetMesh m;
  IdVector<VertId, VertId> whole2part(whole.vert_slots(), kNoVert);
  IdVector<TetId, TetId> tet2part(whole.tet_slots(), kNoTet);
  gid.clear();
  std::vector<VertId> verts;
  for (const TetId t : IdRange<TetId>(whole.tet_slots())) {
    if (label[t] != b) continue;
    auto v = whole.tet2vert[t];
    for (VertId& w : v) {
      if (whole2part[w] == kNoVert) {
        whole2part[w] = to_id<VertId>(verts.size());
        verts.push_back(w);
        gid.push_back(GlobalId{num(w)});
      }
      w = whole2part[w];
    }
    tet2part[t] = m.tet2vert.push_back(v);
    m.face_tag.push_back(whole.face_tag[t]);
    m.tet_ref.push_back(whole.tet_ref[t]);
    m.tet_class.push_back(whole.tet_class[t]);
  }
  for_each_vert_column(m, whole, [&](auto& to, const auto& from) { gather_column(to, from, verts); });
  build_adjacency(m);
  for (const TetId t : IdRange<TetId>(whole.tet_slots())) {
    for (const VertId v : whole.tet2vert[t]) {
      if (label[t] != b && whole2part[v] != kNoVert) m.vert_state[whole2part[v]] |= kFrozen;
    }
    if (tet2part[t] == kNoTet) continue;
    for (const auto& e : kEdgeVerts) {
      const VertId a = whole.tet2vert[t][e[0]];
      const VertId c = whole.tet2vert[t][e[1]];
      if (const FeatureEdge* f = whole.features.find(a, c)) {
        m.features.insert({whole2part[a], whole2part[c], f->ref, f->edge_class});
      }
    }
  }
  m.patch_ref = whole.patch_ref;
  return m;
}

Measures measure(const TetMesh& m) {
  Measures out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    out.volume += volume6(m, t) / 6;
    out.volume_of[m.tet_ref[t]] += volume6(m, t) / 6;
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f];
      if (tag == 0) continue;
      const auto v = m.verts(make_face(t, f));
      out.area_of[tag_patch(tag)] += norm(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]])) / 2;
    }
  }
  for (const auto& e : m.features.list()) out.feature_of[e.ref] += norm(m.coords[e.b] - m.coords[e.a]);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (m.is_live(v) && m.has(v, kCorner | kRequired)) out.fixed.push_back(m.coords[v]);
  }
  std::sort(out.fixed.begin(), out.fixed.end(), [](Vec3 a, Vec3 b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  });
  return out;
}

namespace {
std::string differ(const std::map<int, double>& a, const std::map<int, double>& b, double tolerance, const char* what) {
  if (a.size() != b.size()) return fmt::format("{} of {} kinds, before {}", what, b.size(), a.size());
  for (const auto& [key, value] : a) {
    const auto it = b.find(key);
    if (it == b.end() || !(std::abs(it->second - value) <= tolerance * value)) {
      return fmt::format("{} {} was {:.17g}, is {:.17g}", what, key, value, it == b.end() ? 0.0 : it->second);
    }
  }
  return {};
}
}  // namespace

std::string differ(const Measures& a, const Measures& b, double tolerance, bool surface) {
  if (a.fixed != b.fixed) return "corners or required vertices have changed";
  if (!surface) return {};
  if (!(std::abs(a.volume - b.volume) <= tolerance * a.volume)) {
    return fmt::format("volume was {:.17g}, is {:.17g}", a.volume, b.volume);
  }
  for (const auto& fault : {differ(a.volume_of, b.volume_of, tolerance, "volume of region"),
                            differ(a.area_of, b.area_of, tolerance, "area of patch"),
                            differ(a.feature_of, b.feature_of, tolerance, "length of features")}) {
    if (!fault.empty()) return fault;
  }
  return {};
}

std::vector<std::array<VertId, 3>> interface_faces(const TetMesh& m) {
  std::vector<std::array<VertId, 3>> out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      if (m.tet2face[t][f] != kNoFace || is_hull(m.face_tag[t][f])) continue;
      out.push_back(m.verts(make_face(t, f)));
      std::sort(out.back().begin(), out.back().end());
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace skein::test
