// Arrays to slices and back.
#include "api/slices.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dist/sharing.hpp"

namespace skein {
namespace {

using Numbers = std::vector<std::int64_t>;

void require_range(const Numbers& numbers, std::int64_t total, const char* list, const char* entities) {
  const auto bad = std::find_if(numbers.begin(), numbers.end(), [&](auto i) { return i < 0 || i >= total; });
  if (bad == numbers.end()) return;
  throw Error(ExitCode::kInvalidMesh,
              fmt::format("{} names number {}, but there are {} {}, counted from 0", list, *bad, total, entities));
}

/// The names of the lists that a mesh may have, and of what they list.
void require_ranges(const SlicedMesh& m, const MeshSlice& s) {
  require_range(m.corners, s.total_verts, "the list of corners", "vertices");
  require_range(m.required_verts, s.total_verts, "the list of required vertices", "vertices");
  require_range(m.ridges, s.edges.total, "the list of ridges", "edges");
  require_range(m.required_edges, s.edges.total, "the list of required edges", "edges");
  require_range(m.required_triangles, s.triangles.total, "the list of required triangles", "triangles");
  require_range(m.required_tets, s.tets.total, "the list of required tetrahedra", "tetrahedra");
}

VertexListSlice to_list(const Comm& comm, Numbers numbers) {
  VertexListSlice list;
  list.verts = converted<GlobalId>(std::move(numbers));
  place(comm, list);
  return list;
}

template <std::size_t N>
EntitySlice<N> to_entities(const Comm& comm, std::vector<std::array<std::int64_t, N>> verts,
                           std::vector<std::int32_t>&& refs) {
  EntitySlice<N> list;
  list.verts = converted<std::array<GlobalId, N>>(std::move(verts));
  list.ref = std::move(refs);
  place(comm, list);
  return list;
}

template <std::size_t N>
void from_entities(EntitySlice<N>& list, std::vector<std::array<std::int64_t, N>>& verts,
                   std::vector<std::int32_t>& refs) {
  verts = converted<std::array<std::int64_t, N>>(std::move(list.verts));
  refs = std::move(list.ref);
}

Numbers from_list(VertexListSlice& list) { return converted<std::int64_t>(std::move(list.verts)); }

}  // namespace

void complete_refs(std::vector<std::int32_t>& refs, std::size_t n, const char* entities) {
  if (refs.empty()) refs.assign(n, 0);
  if (refs.size() == n) return;
  throw Error(ExitCode::kInvalidMesh,
              fmt::format("{} references for {} {}; give one for each, or none", refs.size(), n, entities));
}

void require_values(const std::vector<double>& values, int width, std::size_t n, const std::string& what) {
  if (width >= 0 && values.size() == n * static_cast<std::size_t>(width)) return;
  throw Error(ExitCode::kInput, fmt::format("{}: {} numbers on a rank for its {} vertices; {} per vertex are wanted",
                                            what, values.size(), n, width));
}

MeshSlice to_mesh_slice(const Comm& comm, SlicedMesh m) {
  agree(comm, [&] {
    complete_refs(m.vert_refs, m.coords.size(), "vertices");
    complete_refs(m.tet_refs, m.tets.size(), "tetrahedra");
    complete_refs(m.triangle_refs, m.triangles.size(), "triangles");
    complete_refs(m.edge_refs, m.edges.size(), "edges");
  });
  MeshSlice s;
  s.path = "the mesh", s.first_number = 0;
  const auto n = static_cast<std::int64_t>(m.coords.size());
  s.first_vert = comm.exclusive_sum(n), s.total_verts = comm.sum(n);
  s.coords = converted<Vec3>(std::move(m.coords));
  s.vert_ref = std::move(m.vert_refs);
  s.tets = to_entities(comm, std::move(m.tets), std::move(m.tet_refs));
  s.triangles = to_entities(comm, std::move(m.triangles), std::move(m.triangle_refs));
  s.edges = to_entities(comm, std::move(m.edges), std::move(m.edge_refs));
  agree(comm, [&] { require_ranges(m, s); });
  s.corners = to_list(comm, std::move(m.corners));
  s.ridges = to_list(comm, std::move(m.ridges));
  s.required_verts = to_list(comm, std::move(m.required_verts));
  s.required_edges = to_list(comm, std::move(m.required_edges));
  s.required_triangles = to_list(comm, std::move(m.required_triangles));
  s.required_tets = to_list(comm, std::move(m.required_tets));
  return s;
}

std::vector<double> field_slice(const Comm& comm, const DistMesh& dist) {
  const auto owned = owned_verts(comm, dist);
  const VertFields& fields = dist.mesh.fields;
  std::vector<double> out;
  for (const VertId v : IdRange<VertId>(owned.size())) {
    if (owned[v] != 0) out.insert(out.end(), fields.at(v), fields.at(v) + fields.width);
  }
  return out;
}

SlicedMesh to_sliced_mesh(MeshSlice s) {
  SlicedMesh m;
  m.coords = converted<std::array<double, 3>>(std::move(s.coords));
  m.vert_refs = std::move(s.vert_ref);
  from_entities(s.tets, m.tets, m.tet_refs);
  from_entities(s.triangles, m.triangles, m.triangle_refs);
  from_entities(s.edges, m.edges, m.edge_refs);
  m.corners = from_list(s.corners);
  m.ridges = from_list(s.ridges);
  m.required_verts = from_list(s.required_verts);
  m.required_edges = from_list(s.required_edges);
  m.required_triangles = from_list(s.required_triangles);
  m.required_tets = from_list(s.required_tets);
  return m;
}

}  // namespace skein
