// Judging an operation from outside.
#include "tests/kernel/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/check.hpp"

namespace skein::test {
namespace {

bool was_live(const TetMesh& m, TetId t) { return idx(t) < m.tet_slots() && m.is_live(t); }

double quality_cubed_of(const TetMesh& m, TetId t, QualityMeasure measure) {
  const auto& v = m.tet2vert[t];
  if (measure == QualityMeasure::kLeast) {
    return least_quality_cubed(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]], m.metric[v[0]],
                               m.metric[v[1]], m.metric[v[2]], m.metric[v[3]]);
  }
  return quality_cubed(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]], m.metric[v[0]], m.metric[v[1]],
                       m.metric[v[2]], m.metric[v[3]]);
}

bool same_edges(const FeatureEdges& a, const FeatureEdges& b) {
  if (a.size() != b.size()) return false;
  return std::all_of(a.list().begin(), a.list().end(), [&](const FeatureEdge& e) {
    const FeatureEdge* o = b.find(e.a, e.b);
    return o != nullptr && o->ref == e.ref && o->edge_class == e.edge_class;
  });
}

bool same_vertex(const Snapshot& before, const Part& after, VertId v) {
  const TetMesh &a = before.mesh, &b = after.mesh;
  return a.coords[v] == b.coords[v] && a.vert_ref[v] == b.vert_ref[v] && a.vert_class[v] == b.vert_class[v] &&
         a.vert_state[v] == b.vert_state[v] && a.log_metric[v] == b.log_metric[v] && a.metric[v].m == b.metric[v].m &&
         a.metric[v].sqrt_det == b.metric[v].sqrt_det;
}

/// Required triangles by their sorted vertices, with their tags.
std::vector<std::pair<std::array<VertId, 3>, FaceTag>> required_faces(const TetMesh& m) {
  std::vector<std::pair<std::array<VertId, 3>, FaceTag>> out;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f];
      if ((tag & kRequiredFace) == 0) continue;
      auto v = m.verts(make_face(t, f));
      std::sort(v.begin(), v.end());
      out.emplace_back(v, tag);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

std::string differ(const Snapshot& before, const Part& after) {
  const TetMesh &a = before.mesh, &b = after.mesh;
  for (const TetId t : IdRange<TetId>(b.tet_slots())) {
    if (was_live(a, t) != b.is_live(t)) return fmt::format("tetrahedron {} has come or gone", num(t));
    if (!b.is_live(t)) continue;
    if (a.tet2vert[t] != b.tet2vert[t] || a.tet2face[t] != b.tet2face[t] || a.face_tag[t] != b.face_tag[t] ||
        a.tet_ref[t] != b.tet_ref[t] || before.q3[t] != after.q3[t]) {
      return fmt::format("tetrahedron {} has changed", num(t));
    }
  }
  for (const VertId v : IdRange<VertId>(b.vert_slots())) {
    const bool lived = idx(v) < a.vert_slots() && a.is_live(v);
    if (lived != b.is_live(v)) return fmt::format("vertex {} has come or gone", num(v));
    if (!lived) continue;
    if (a.vert2tet[v] != b.vert2tet[v] || !same_vertex(before, after, v)) {
      return fmt::format("vertex {} has changed", num(v));
    }
  }
  return same_edges(a.features, b.features) ? "" : "feature edges have changed";
}

Change change(const Snapshot& before, const Part& after, VertId moved) {
  Change c;
  for (const TetId t : IdRange<TetId>(after.mesh.tet_slots())) {
    const bool lived = was_live(before.mesh, t), lives = after.mesh.is_live(t);
    if (lived && lives && before.mesh.tet2vert[t] == after.mesh.tet2vert[t] &&
        (moved == kNoVert || !has_vertex(after.mesh.tet2vert[t], moved))) {
      continue;
    }
    if (lived) {
      c.gone.push_back(t);
      const double q3 = quality_cubed_of(before.mesh, t, before.quality_measure);
      c.old_min = std::min(c.old_min, q3);
      c.old_sum += inverse_sixth_power(q3);
    }
    if (lives) {
      c.fresh.push_back(t);
      const double q3 = quality_cubed_of(after.mesh, t, after.quality_measure);
      c.new_min = std::min(c.new_min, q3);
      c.new_sum += inverse_sixth_power(q3);
    }
  }
  return c;
}

std::string judge(const Part& part) {
  const TetMesh& m = part.mesh;
  if (auto fault = check(m); !fault.empty()) return fault;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    const double q = quality_cubed(part, t);
    if (!(std::abs(part.q3[t] - q) <= 1e-6 * q)) return fmt::format("cached quality of {} is wrong", num(t));
  }
  // Every feature edge is an edge of the mesh with a tagged face; every vertex that has lost its faces its mark, too.
  FeatureEdges used;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (const auto& e : kEdgeVerts) {
      const VertId a = m.tet2vert[t][e[0]], b = m.tet2vert[t][e[1]];
      if (const FeatureEdge* f = m.features.find(a, b)) used.insert({a, b, f->ref, f->edge_class});
    }
  }
  if (used.size() != m.features.size()) return "a feature edge is no edge of any tetrahedron";
  return {};
}

std::string judge(const Snapshot& before, const Part& after, double tolerance, VertId moved) {
  if (auto fault = judge(after); !fault.empty()) return fault;
  const TetMesh &a = before.mesh, &b = after.mesh;
  for (const VertId v : IdRange<VertId>(a.vert_slots())) {
    if (!a.is_live(v)) continue;
    const bool fixed = a.has(v, kFrozen) || a.has(v, kCorner | kRequired);
    if (fixed && !b.is_live(v)) return fmt::format("fixed vertex {} has gone", num(v));
    if (b.is_live(v) && (fixed || v != moved) && !same_vertex(before, after, v)) {
      return fmt::format("vertex {} has changed", num(v));
    }
  }
  if (interface_faces(a) != interface_faces(b)) return "interface faces have changed";
  if (required_faces(a) != required_faces(b)) return "required triangles have changed";
  return differ(measure(a), measure(b), tolerance, tolerance > 0);
}

}  // namespace skein::test
