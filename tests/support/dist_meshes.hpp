// Whole meshes as slices of a file and as distributed meshes, and what no redistribution may change in them.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "base/tensor.hpp"
#include "comm/comm.hpp"
#include "comm/file.hpp"
#include "dist/distribute.hpp"
#include "dist/gather_slices.hpp"
#include "dist/interface.hpp"
#include "dist/migrate.hpp"
#include "dist/reconcile.hpp"
#include "mesh/check.hpp"
#include "mesh/mesh_slice.hpp"
#include "tests/support/whole_mesh.hpp"

namespace skein::test {

template <std::size_t N>
void cut(const Comm& comm, const std::vector<std::array<std::int64_t, N>>& all, const std::vector<std::int32_t>& ref,
         EntitySlice<N>& out) {
  out.total = static_cast<std::int64_t>(all.size());
  const Slice s = even_slice(out.total, comm.rank(), comm.size());
  out.first = s.first;
  for (auto i = static_cast<std::size_t>(s.first); i < static_cast<std::size_t>(s.last); ++i) {
    std::array<GlobalId, N> v;
    for (std::size_t k = 0; k < N; ++k) v[k] = GlobalId{all[i][k]};
    out.verts.push_back(v);
    out.ref.push_back(ref[i]);
  }
}
inline void cut(const Comm& comm, const std::vector<std::int64_t>& all, VertexListSlice& out) {
  out.total = static_cast<std::int64_t>(all.size());
  const Slice s = even_slice(out.total, comm.rank(), comm.size());
  out.first = s.first;
  for (std::int64_t i = s.first; i < s.last; ++i) out.verts.push_back(GlobalId{all[i]});
}

/// This rank's even slices.
inline MeshSlice slices(const Comm& comm, const WholeMesh& w) {
  MeshSlice m;
  m.path = "cube.mesh";
  m.total_verts = static_cast<std::int64_t>(w.coords.size());
  const Slice s = even_slice(m.total_verts, comm.rank(), comm.size());
  m.first_vert = s.first;
  m.coords.assign(w.coords.begin() + s.first, w.coords.begin() + s.last);
  for (std::int64_t v = s.first; v < s.last; ++v) m.vert_ref.push_back(static_cast<std::int32_t>(v % 5));
  cut(comm, w.tets, w.tet_ref, m.tets);
  cut(comm, w.tris, w.tri_ref, m.triangles);
  cut(comm, w.edges, w.edge_ref, m.edges);
  cut(comm, w.corners, m.corners);
  cut(comm, w.ridges, m.ridges);
  cut(comm, w.required_verts, m.required_verts);
  cut(comm, w.required_tris, m.required_triangles);
  return m;
}

/// A log-metric (6 numbers, sizes that fall with x) and one scalar x + 2 y + 4 z at the vertices of the slice.
inline FieldSlice fields(const MeshSlice& m) {
  FieldSlice f;
  f.path = "cube.sol";
  f.total = m.total_verts;
  f.first = m.first_vert;
  f.kinds = {FieldKind::kTensor, FieldKind::kScalar};
  f.width = 7;
  for (const Vec3 x : m.coords) {
    const double l = 2 + 6 * x.x;
    f.values.insert(f.values.end(), {l, 0, l, 0, 0, l, x.x + 2 * x.y + 4 * x.z});
  }
  return f;
}

/// Entities by coordinates: sorted, so that equal sets compare equal whatever the numbering.
using Items = std::vector<std::vector<double>>;
struct Content {
  Items verts, tets, tris, edges, ridges, corners, required_verts, required_tris;
  friend bool operator==(const Content&, const Content&) = default;
};

/// Collective. All ranks' slices as one Content (the same on every rank).
inline Content content(const Comm& comm, const MeshSlice& m) {
  const auto coords = comm.all_gather(m.coords);
  const auto vert_ref = comm.all_gather(m.vert_ref);
  const auto entities = [&]<std::size_t N>(const EntitySlice<N>& list) {
    const auto verts = comm.all_gather(list.verts);
    const auto ref = comm.all_gather(list.ref);
    Items out;
    for (std::size_t i = 0; i < verts.size(); ++i) {
      std::array<std::array<double, 3>, N> x;
      for (std::size_t k = 0; k < N; ++k) {
        const Vec3 p = coords.at(idx(verts[i][k]));
        x[k] = {p.x, p.y, p.z};
      }
      std::sort(x.begin(), x.end());
      std::vector<double> item;
      for (const auto& p : x) item.insert(item.end(), p.begin(), p.end());
      item.push_back(ref[i]);
      out.push_back(item);
    }
    return out;
  };
  const auto chosen = [&](const Items& of, const VertexListSlice& list) {
    Items out;
    for (const GlobalId g : comm.all_gather(list.verts)) out.push_back(of.at(idx(g)));
    std::sort(out.begin(), out.end());
    return out;
  };
  Content c;
  for (std::size_t v = 0; v < coords.size(); ++v)
    c.verts.push_back({coords[v].x, coords[v].y, coords[v].z, double(vert_ref.at(v))});
  c.corners = chosen(c.verts, m.corners);
  c.required_verts = chosen(c.verts, m.required_verts);
  c.tets = entities(m.tets);
  c.tris = entities(m.triangles);
  c.required_tris = chosen(c.tris, m.required_triangles);
  c.edges = entities(m.edges);
  c.ridges = chosen(c.edges, m.ridges);
  for (Items* i : {&c.verts, &c.tets, &c.tris, &c.edges}) std::sort(i->begin(), i->end());
  return c;
}

/// Collective. Volume, area by patch reference, length of features: what no redistribution may change.
struct Measure {
  double volume = 0, feature_length = 0;
  std::map<int, double> area;
};
inline Measure measure(const Comm& comm, const DistMesh& dist) {
  Measure m;
  m.volume = comm.sum(volume(dist.mesh));
  const MeshSlice s = to_slices(comm, dist);
  const auto coords = comm.all_gather(s.coords);
  const auto tris = comm.all_gather(s.triangles.verts);
  const auto refs = comm.all_gather(s.triangles.ref);
  for (std::size_t i = 0; i < tris.size(); ++i) {
    const Vec3 a = coords[idx(tris[i][0])], b = coords[idx(tris[i][1])], c = coords[idx(tris[i][2])];
    m.area[refs[i]] += 0.5 * norm(cross(b - a, c - a));
  }
  for (const auto& e : comm.all_gather(s.edges.verts)) m.feature_length += norm(coords[idx(e[1])] - coords[idx(e[0])]);
  return m;
}

/// Every tetrahedron to any rank.
inline IdVector<TetId, Rank> scatter(const Comm& comm, const DistMesh& dist, unsigned seed) {
  std::mt19937 random(seed * 1000 + static_cast<unsigned>(num(comm.rank())));
  IdVector<TetId, Rank> dest(dist.mesh.tet_slots());
  for (auto& r : dest) r = to_id<Rank>(random() % static_cast<unsigned>(comm.size()));
  return dest;
}

/// Collective. What InterfaceRegion::displace gives, as a rank for each tetrahedron.
inline IdVector<TetId, Rank> displace_interface(const Comm& comm, DistMesh& dist, int layers, int round,
                                                GlobalId before = kEveryGlobal) {
  IdVector<TetId, Rank> dest(dist.mesh.tet_slots(), comm.rank());
  const Moves moves = InterfaceRegion(comm, dist, layers).displace(layers, round, before);
  for (std::size_t i = 0; i < moves.tets.size(); ++i) dest[moves.tets[i]] = moves.to[i];
  return dest;
}

/// Collective. What InterfaceRegion::mark_active does.
inline bool mark_active_band(const Comm& comm, DistMesh& dist, int layers, GlobalId before = kEveryGlobal) {
  return InterfaceRegion(comm, dist, layers).mark_active(layers, before);
}

/// Collective. The whole mesh on all ranks with the log-metric log_metric(x).
template <class LogMetric>
DistMesh with_metric(const Comm& comm, const WholeMesh& whole, LogMetric&& log_metric) {
  const MeshSlice file = slices(comm, whole);
  FieldSlice f;
  f.path = "cube.sol";
  f.total = file.total_verts;
  f.first = file.first_vert;
  f.kinds = {FieldKind::kTensor};
  f.width = 6;
  for (const Vec3 x : file.coords) {
    const SymTensor l = log_metric(x);
    f.values.insert(f.values.end(), {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz});
  }
  DistributeOptions options;
  options.metric_first = true;
  return distribute(comm, file, &f, options);
}

}  // namespace skein::test
