// Slices for writing: every entity on exactly one rank.
#include "dist/gather_slices.hpp"

#include <algorithm>
#include <tuple>

#include "dist/interface.hpp"
#include "dist/rendezvous.hpp"
#include "dist/sharing.hpp"

namespace skein {
namespace {

void place(const Comm& comm, std::size_t n, std::int64_t& first, std::int64_t& total) {
  first = comm.exclusive_sum(static_cast<std::int64_t>(n));
  total = comm.sum(static_cast<std::int64_t>(n));
}
void place(const Comm& comm, VertexListSlice& list) { place(comm, list.verts.size(), list.first, list.total); }

/// One side of an internal tagged face between two ranks.
struct Side {
  std::array<GlobalId, 3> gid;
  std::int32_t tet_ref;
  Rank rank;
};

/// True for each of these interface faces that this rank writes: that of the lower (region, rank).
std::vector<std::uint8_t> chosen_sides(const Comm& comm, const DistMesh& dist, const std::vector<FaceId>& faces) {
  std::vector<Rank> dest;
  std::vector<Side> sides;
  for (const FaceId f : faces) {
    const FaceKey key = face_key(dist.mesh, dist.vert2gid, f);
    dest.push_back(meeting_rank(key.gid, comm.size()));
    sides.push_back({key.gid, dist.mesh.tet_ref[face_tet(f)], comm.rank()});
  }
  const Inquiry<Side> inquiry(comm, dest, sides);
  const auto& met = inquiry.asked().items;
  std::vector<std::size_t> order(met.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return std::tie(met[i].gid, met[i].tet_ref, met[i].rank) < std::tie(met[j].gid, met[j].tet_ref, met[j].rank);
  });
  std::vector<std::uint8_t> chosen(met.size(), 0);
  for (std::size_t i = 0; i < order.size(); ++i)
    chosen[order[i]] = i == 0 || met[order[i]].gid != met[order[i - 1]].gid ? 1 : 0;
  return inquiry.answer(chosen);
}

}  // namespace

std::vector<FaceId> faces_to_write(const Comm& comm, const DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  std::vector<FaceId> out, between;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (m.face_tag[t][k] == 0) continue;
      const FaceId me = make_face(t, k), other = m.tet2face[t][k];
      if (other != kNoFace) {
        if (std::pair(m.tet_ref[t], me) < std::pair(m.tet_ref[face_tet(other)], other)) out.push_back(me);
      } else if (is_hull(m.face_tag[t][k])) {
        out.push_back(me);
      } else {
        between.push_back(me);
      }
    }
  }
  const auto chosen = chosen_sides(comm, dist, between);
  for (std::size_t i = 0; i < between.size(); ++i) {
    if (chosen[i] != 0) out.push_back(between[i]);
  }
  std::sort(out.begin(), out.end());
  return out;
}

// An edge with an unshared end is on no other rank; of the others the lowest rank that has it writes it.
std::vector<FeatureEdge> edges_to_write(const Comm& comm, const DistMesh& dist) {
  struct Copy {
    GlobalId a, b;
    Rank rank;
  };
  IdVector<VertId, char> shared(dist.mesh.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) shared[v] = 1;
  std::vector<FeatureEdge> edges(dist.mesh.features.list());
  std::erase_if(edges, [](const FeatureEdge& e) { return e.has(kImpliedEdge); });
  std::sort(edges.begin(), edges.end(),
            [](const FeatureEdge& e, const FeatureEdge& f) { return std::pair(e.a, e.b) < std::pair(f.a, f.b); });
  std::vector<std::uint8_t> write(edges.size(), 1);
  std::vector<std::size_t> doubtful;
  std::vector<Rank> dest;
  std::vector<Copy> copies;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (shared[edges[i].a] == 0 || shared[edges[i].b] == 0) continue;
    const auto [a, b] = std::minmax(dist.vert2gid[edges[i].a], dist.vert2gid[edges[i].b]);
    doubtful.push_back(i);
    dest.push_back(meeting_rank(a, comm.size()));
    copies.push_back({a, b, comm.rank()});
  }
  const Inquiry<Copy> inquiry(comm, dest, copies);
  const auto& met = inquiry.asked().items;  // by source rank, so the first of equal ones is the lowest rank's
  std::vector<std::size_t> order(met.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return std::tie(met[i].a, met[i].b, i) < std::tie(met[j].a, met[j].b, j);
  });
  std::vector<std::uint8_t> mine(met.size(), 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool again = i > 0 && met[order[i]].a == met[order[i - 1]].a && met[order[i]].b == met[order[i - 1]].b;
    mine[order[i]] = again ? 0 : 1;
  }
  const auto answer = inquiry.answer(mine);
  for (std::size_t i = 0; i < doubtful.size(); ++i) write[doubtful[i]] = answer[i];
  std::vector<FeatureEdge> out;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (write[i] != 0) out.push_back(edges[i]);
  }
  return out;
}

MeshSlice to_slices(const Comm& comm, const DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  const auto number = compact_numbers(comm, dist);
  const auto owned = owned_verts(comm, dist);
  const auto gid = [&](VertId v) { return GlobalId{number[idx(v)]}; };
  MeshSlice s;
  s.coords.reserve(m.vert_slots());
  s.vert_ref.reserve(m.vert_slots());
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (owned[v] == 0) continue;
    s.coords.push_back(m.coords[v]);
    s.vert_ref.push_back(m.vert_ref[v]);
    if (m.has(v, kCorner)) s.corners.verts.push_back(gid(v));
    if (m.has(v, kRequired)) s.required_verts.verts.push_back(gid(v));
  }
  place(comm, s.coords.size(), s.first_vert, s.total_verts);
  s.tets.ref = m.tet_ref.raw();
  s.tets.verts.reserve(m.tet_slots());
  for (const auto& v : m.tet2vert) s.tets.verts.push_back({gid(v[0]), gid(v[1]), gid(v[2]), gid(v[3])});
  place(comm, s.tets.verts.size(), s.tets.first, s.tets.total);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (m.has(t, kRequiredTet)) s.required_tets.verts.push_back(GlobalId{s.tets.first + num(t)});
  }

  const auto faces = faces_to_write(comm, dist);
  place(comm, faces.size(), s.triangles.first, s.triangles.total);
  for (const FaceId f : faces) {
    const FaceTag tag = m.tag(f);
    const auto v = m.verts(f);
    if ((tag & kRequiredFace) != 0)
      s.required_triangles.verts.push_back(to_id<GlobalId>(s.triangles.first + std::ssize(s.triangles.verts)));
    s.triangles.verts.push_back({gid(v[0]), gid(v[1]), gid(v[2])});
    s.triangles.ref.push_back(m.patch_ref[tag_patch(tag)]);
  }
  const auto edges = edges_to_write(comm, dist);
  place(comm, edges.size(), s.edges.first, s.edges.total);
  for (const auto& e : edges) {
    const auto number = to_id<GlobalId>(s.edges.first + std::ssize(s.edges.verts));
    if (e.has(kRidgeEdge)) s.ridges.verts.push_back(number);
    if (e.has(kRequiredEdge)) s.required_edges.verts.push_back(number);
    s.edges.verts.push_back({gid(e.a), gid(e.b)});
    s.edges.ref.push_back(e.ref);
  }
  for (VertexListSlice* list :
       {&s.corners, &s.ridges, &s.required_verts, &s.required_edges, &s.required_triangles, &s.required_tets})
    place(comm, *list);
  return s;
}

namespace {

/// Collective. `append(values, v)` adds the numbers of vertex v; they are of these kinds.
template <class Append>
FieldSlice field_slice(const Comm& comm, const DistMesh& dist, const std::vector<FieldKind>& kinds, Append&& append) {
  FieldSlice s;
  s.kinds = kinds;
  for (const FieldKind k : kinds) s.width += components(k);
  const auto owned = owned_verts(comm, dist);
  std::size_t n = 0;
  for (const VertId v : IdRange<VertId>(owned.size())) {
    if (owned[v] == 0) continue;
    ++n;
    append(s.values, v);
  }
  place(comm, n, s.first, s.total);
  return s;
}

}  // namespace

FieldSlice to_field_slices(const Comm& comm, const DistMesh& dist, const std::vector<FieldKind>& kinds) {
  return field_slice(comm, dist, kinds, [&](std::vector<double>& values, VertId v) {
    const VertFields& f = dist.mesh.fields;
    values.insert(values.end(), f.at(v), f.at(v) + f.width);
  });
}

FieldSlice to_metric_slices(const Comm& comm, const DistMesh& dist) {
  return field_slice(comm, dist, {FieldKind::kTensor}, [&](std::vector<double>& values, VertId v) {
    const SymTensor& l = dist.mesh.log_metric[v];
    values.insert(values.end(), {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz});
  });
}

}  // namespace skein
