// The C functions: a handle round the arrays of skein.hpp; nothing is thrown past them.
#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "skein/skein.h"
#include "skein/skein.hpp"

/// Numbers are kept with 64 bits for both conventions.
struct skein_mesh {
  skein::SlicedMesh mesh;
  bool in_parts = false;
  std::vector<std::int64_t> local2global;
  skein::Target target;
  skein::Fields fields;
  std::vector<double> metric;
};

namespace {

using skein::Error;
using skein::ErrorCode;

thread_local std::string last_error;

/// Runs `work`; what it throws becomes a status and a text.
template <class Work>
int guarded(Work&& work) noexcept {
  const auto fail = [](ErrorCode code, const char* line) noexcept {
    try {
      last_error = line;
    } catch (...) {
      last_error.clear();
    }
    return static_cast<int>(code);
  };
  try {
    work();
    return SKEIN_OK;
  } catch (const Error& e) {
    return fail(e.code(), e.what());
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kInternal, "out of memory");
  } catch (const std::exception& e) {
    return fail(ErrorCode::kInternal, e.what());
  } catch (...) {
    return fail(ErrorCode::kInternal, "unknown exception");
  }
}

void require(bool holds, const char* line) {
  if (!holds) throw Error(ErrorCode::kUsage, line);
}

template <class T>
std::vector<T> copied(std::int64_t n, const T* values) {
  require(n >= 0, "a count is negative");
  require(n == 0 || values != nullptr, "an array is NULL");
  return n == 0 ? std::vector<T>() : std::vector<T>(values, values + n);
}

template <std::size_t N, class T>
std::vector<std::array<T, N>> copied_rows(std::int64_t n, const T* values) {
  require(n >= 0, "a count is negative");
  require(n == 0 || values != nullptr, "an array is NULL");
  std::vector<std::array<T, N>> rows(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < rows.size(); ++i) std::copy_n(values + N * i, N, rows[i].begin());
  return rows;
}

std::vector<std::int32_t> copied_refs(std::int64_t n, const std::int32_t* refs) {
  return refs == nullptr ? std::vector<std::int32_t>() : copied(n, refs);
}

template <std::size_t N>
int set_entities(skein_mesh* mesh, std::vector<std::array<std::int64_t, N>> skein::SlicedMesh::*verts,
                 std::vector<std::int32_t> skein::SlicedMesh::*refs, std::int64_t n, const std::int64_t* new_verts,
                 const std::int32_t* new_refs) noexcept {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    auto rows = copied_rows<N>(n, new_verts);
    mesh->mesh.*refs = copied_refs(n, new_refs);
    mesh->mesh.*verts = std::move(rows);
  });
}

int set_list(skein_mesh* mesh, std::vector<std::int64_t> skein::SlicedMesh::*list, std::int64_t n,
             const std::int64_t* numbers) noexcept {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    mesh->mesh.*list = copied(n, numbers);
  });
}

// --- numbers of 32 bits and of 64

/// What is out of range becomes -1, which adapt() refuses on all ranks; to throw here would leave the others waiting.
void convert(std::int64_t from, std::int32_t& to) noexcept {
  to = from >= 0 && from <= std::numeric_limits<std::int32_t>::max() ? static_cast<std::int32_t>(from) : -1;
}
void convert(std::int32_t from, std::int64_t& to) noexcept { to = from; }
template <class From, class To, std::size_t N>
void convert(const std::array<From, N>& from, std::array<To, N>& to) noexcept {
  for (std::size_t k = 0; k < N; ++k) convert(from[k], to[k]);
}
/// All items; `from` is freed.
template <class From, class To>
void convert(std::vector<From>& from, std::vector<To>& to) {
  to.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) convert(from[i], to[i]);
  std::vector<From>().swap(from);
}

/// All arrays of a mesh in the other convention, but for the global numbers.
template <class To, class From>
To converted(From from) {
  To to;
  to.coords = std::move(from.coords);
  to.vert_refs = std::move(from.vert_refs), to.tet_refs = std::move(from.tet_refs);
  to.triangle_refs = std::move(from.triangle_refs), to.edge_refs = std::move(from.edge_refs);
  convert(from.tets, to.tets), convert(from.triangles, to.triangles), convert(from.edges, to.edges);
  convert(from.corners, to.corners), convert(from.required_verts, to.required_verts);
  convert(from.ridges, to.ridges), convert(from.required_edges, to.required_edges);
  convert(from.required_triangles, to.required_triangles), convert(from.required_tets, to.required_tets);
  return to;
}

// --- options and report

skein::Options to_cpp(const skein_options& o) {
  skein::Options out;
  out.complexity = o.complexity, out.h_min = o.h_min, out.h_max = o.h_max, out.norm = o.norm;
  out.elements = o.elements, out.vertices = o.vertices, out.aspect_max = o.aspect_max;
  if (!(o.gradation < 0)) out.gradation = o.gradation;
  out.ridge_angle = o.ridge_angle, out.surface = o.surface != 0;
  const auto text = [](const char* s) { return s == nullptr ? std::string() : std::string(s); };
  out.preset = text(o.preset), out.config = text(o.config), out.config_file = text(o.config_file);
  using Points = skein::Options::Points;
  using Smoothing = skein::Options::Smoothing;
  if (o.points == SKEIN_POINTS_EDGES) out.points = Points::kEdges;
  if (o.points == SKEIN_POINTS_CENTROIDS) out.points = Points::kCentroids;
  if (o.smoothing == SKEIN_SMOOTHING_QUALITY) out.smoothing = Smoothing::kQuality;
  if (o.smoothing == SKEIN_SMOOTHING_SPRINGS) out.smoothing = Smoothing::kSprings;
  out.rounds = o.rounds, out.threads = o.threads, out.return_metric = o.return_metric != 0;
  if (o.progress == nullptr) return out;
  out.progress = [tell = o.progress, data = o.progress_data](const skein::Progress& p) {
    const skein_progress now{p.phase.c_str(), p.finished ? 1 : 0, p.seconds, p.tets};
    return tell(&now, data) != 0;
  };
  return out;
}

skein_report to_c(const skein::Report& r) noexcept {
  return {r.vertices_in, r.tets_in,     r.vertices,     r.tets,   r.complexity,
          r.unit_edges,  r.quality_min, r.quality_mean, r.seconds};
}

/// Takes all but the mesh from what came out.
template <class Mesh>
void take(skein::Adapted<Mesh>& from, skein_mesh& to, skein_report* report) {
  to.fields = std::move(from.fields), to.metric = std::move(from.metric);
  if (report != nullptr) *report = to_c(from.report);
}

void adapt(MPI_Comm comm, skein_mesh& mesh, const skein::Options& options, skein_report* report) {
  skein_mesh in = std::exchange(mesh, {});
  mesh.in_parts = in.in_parts;
  if (in.in_parts) {
    auto parts = converted<skein::PartitionedMesh>(std::move(in.mesh));
    parts.local2global = std::move(in.local2global);
    auto out = skein::adapt(comm, std::move(parts), std::move(in.target), std::move(in.fields), options);
    mesh.local2global = std::move(out.mesh.local2global);
    mesh.mesh = converted<skein::SlicedMesh>(std::move(out.mesh));
    take(out, mesh, report);
  } else {
    auto out = skein::adapt(comm, std::move(in.mesh), std::move(in.target), std::move(in.fields), options);
    mesh.mesh = std::move(out.mesh);
    take(out, mesh, report);
  }
}

/// The first number of an array of rows, NULL of an empty one.
template <class T>
const T* flat(const std::vector<T>& v) noexcept {
  return v.empty() ? nullptr : v.data();
}
template <class T, std::size_t N>
const T* flat(const std::vector<std::array<T, N>>& v) noexcept {
  return v.empty() ? nullptr : v.front().data();
}
template <class List>
std::int64_t count(const List& list) noexcept {
  return static_cast<std::int64_t>(list.size());
}

}  // namespace

extern "C" {

const char* skein_version(void) { return skein::version(); }
const char* skein_last_error(void) { return last_error.c_str(); }

void skein_options_init(skein_options* options) {
  const skein::Options o;
  *options = {};
  options->complexity = o.complexity, options->h_min = o.h_min, options->h_max = o.h_max, options->norm = o.norm;
  options->gradation = -1, options->ridge_angle = o.ridge_angle, options->surface = o.surface ? 1 : 0;
  options->points = SKEIN_POINTS_OF_METHOD, options->smoothing = SKEIN_SMOOTHING_OF_METHOD;
  options->rounds = o.rounds, options->threads = o.threads;
}

// NOLINTNEXTLINE(cppcoreguidelines-owning-memory): the caller in C owns the handle
skein_mesh* skein_mesh_create(void) { return new (std::nothrow) skein_mesh; }
void skein_mesh_destroy(skein_mesh* mesh) { const std::unique_ptr<skein_mesh> last(mesh); }

int skein_set_vertices(skein_mesh* mesh, int64_t n, const double* coords, const int32_t* refs) {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    mesh->mesh.coords = copied_rows<3>(n, coords);
    mesh->mesh.vert_refs = copied_refs(n, refs);
    mesh->in_parts = false;
    mesh->local2global.clear(), mesh->target = {}, mesh->fields = {}, mesh->metric.clear();
  });
}

int skein_set_local_to_global(skein_mesh* mesh, const int64_t* numbers) {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    mesh->local2global = copied(count(mesh->mesh.coords), numbers);
    mesh->in_parts = true;
  });
}

int skein_set_tetrahedra(skein_mesh* mesh, int64_t n, const int64_t* verts, const int32_t* refs) {
  return set_entities<4>(mesh, &skein::SlicedMesh::tets, &skein::SlicedMesh::tet_refs, n, verts, refs);
}
int skein_set_triangles(skein_mesh* mesh, int64_t n, const int64_t* verts, const int32_t* refs) {
  return set_entities<3>(mesh, &skein::SlicedMesh::triangles, &skein::SlicedMesh::triangle_refs, n, verts, refs);
}
int skein_set_edges(skein_mesh* mesh, int64_t n, const int64_t* verts, const int32_t* refs) {
  return set_entities<2>(mesh, &skein::SlicedMesh::edges, &skein::SlicedMesh::edge_refs, n, verts, refs);
}
int skein_set_corners(skein_mesh* mesh, int64_t n, const int64_t* verts) {
  return set_list(mesh, &skein::SlicedMesh::corners, n, verts);
}
int skein_set_required_vertices(skein_mesh* mesh, int64_t n, const int64_t* verts) {
  return set_list(mesh, &skein::SlicedMesh::required_verts, n, verts);
}
int skein_set_ridges(skein_mesh* mesh, int64_t n, const int64_t* edges) {
  return set_list(mesh, &skein::SlicedMesh::ridges, n, edges);
}
int skein_set_required_edges(skein_mesh* mesh, int64_t n, const int64_t* edges) {
  return set_list(mesh, &skein::SlicedMesh::required_edges, n, edges);
}
int skein_set_required_triangles(skein_mesh* mesh, int64_t n, const int64_t* triangles) {
  return set_list(mesh, &skein::SlicedMesh::required_triangles, n, triangles);
}
int skein_set_required_tetrahedra(skein_mesh* mesh, int64_t n, const int64_t* tets) {
  return set_list(mesh, &skein::SlicedMesh::required_tets, n, tets);
}

int skein_set_target(skein_mesh* mesh, skein_target kind, const double* values) {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    require(kind == SKEIN_METRIC || kind == SKEIN_SIZE || kind == SKEIN_FIELD || kind == SKEIN_OWN_SIZES,
            "the target is of an unknown kind");
    const int width = kind == SKEIN_METRIC ? 6 : kind == SKEIN_OWN_SIZES ? 0 : 1;
    mesh->target.values = copied(count(mesh->mesh.coords) * width, values);
    mesh->target.kind = kind == SKEIN_METRIC  ? skein::Target::Kind::kMetric
                        : kind == SKEIN_SIZE  ? skein::Target::Kind::kSize
                        : kind == SKEIN_FIELD ? skein::Target::Kind::kField
                                              : skein::Target::Kind::kOwnSizes;
  });
}

int skein_set_fields(skein_mesh* mesh, int width, const double* values) {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    require(width >= 0, "the width is negative");
    mesh->fields.values = copied(count(mesh->mesh.coords) * width, values);
    mesh->fields.width = width;
  });
}

int skein_adapt(MPI_Comm comm, skein_mesh* mesh, const skein_options* options, skein_report* report) {
  return guarded([&] {
    require(mesh != nullptr, "the mesh is NULL");
    adapt(comm, *mesh, options == nullptr ? skein::Options() : to_cpp(*options), report);
  });
}

int64_t skein_count_vertices(const skein_mesh* mesh) { return count(mesh->mesh.coords); }
int64_t skein_count_tetrahedra(const skein_mesh* mesh) { return count(mesh->mesh.tets); }
int64_t skein_count_triangles(const skein_mesh* mesh) { return count(mesh->mesh.triangles); }
int64_t skein_count_edges(const skein_mesh* mesh) { return count(mesh->mesh.edges); }
int64_t skein_count_corners(const skein_mesh* mesh) { return count(mesh->mesh.corners); }
int64_t skein_count_required_vertices(const skein_mesh* mesh) { return count(mesh->mesh.required_verts); }
int64_t skein_count_ridges(const skein_mesh* mesh) { return count(mesh->mesh.ridges); }
int64_t skein_count_required_edges(const skein_mesh* mesh) { return count(mesh->mesh.required_edges); }
int64_t skein_count_required_tetrahedra(const skein_mesh* mesh) { return count(mesh->mesh.required_tets); }
int64_t skein_count_required_triangles(const skein_mesh* mesh) { return count(mesh->mesh.required_triangles); }
const double* skein_vertices(const skein_mesh* mesh) { return flat(mesh->mesh.coords); }
const int32_t* skein_vertex_refs(const skein_mesh* mesh) { return flat(mesh->mesh.vert_refs); }
const int64_t* skein_local_to_global(const skein_mesh* mesh) {
  return mesh->in_parts ? flat(mesh->local2global) : nullptr;
}
const int64_t* skein_tetrahedra(const skein_mesh* mesh) { return flat(mesh->mesh.tets); }
const int32_t* skein_tetrahedron_refs(const skein_mesh* mesh) { return flat(mesh->mesh.tet_refs); }
const int64_t* skein_triangles(const skein_mesh* mesh) { return flat(mesh->mesh.triangles); }
const int32_t* skein_triangle_refs(const skein_mesh* mesh) { return flat(mesh->mesh.triangle_refs); }
const int64_t* skein_edges(const skein_mesh* mesh) { return flat(mesh->mesh.edges); }
const int32_t* skein_edge_refs(const skein_mesh* mesh) { return flat(mesh->mesh.edge_refs); }
const int64_t* skein_corners(const skein_mesh* mesh) { return flat(mesh->mesh.corners); }
const int64_t* skein_required_vertices(const skein_mesh* mesh) { return flat(mesh->mesh.required_verts); }
const int64_t* skein_ridges(const skein_mesh* mesh) { return flat(mesh->mesh.ridges); }
const int64_t* skein_required_edges(const skein_mesh* mesh) { return flat(mesh->mesh.required_edges); }
const int64_t* skein_required_tetrahedra(const skein_mesh* mesh) { return flat(mesh->mesh.required_tets); }
const int64_t* skein_required_triangles(const skein_mesh* mesh) { return flat(mesh->mesh.required_triangles); }
int skein_field_width(const skein_mesh* mesh) { return mesh->fields.width; }
const double* skein_fields(const skein_mesh* mesh) { return flat(mesh->fields.values); }
const double* skein_metric(const skein_mesh* mesh) { return flat(mesh->metric); }

}  // extern "C"
