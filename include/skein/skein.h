/// \file
/// Skein in memory, for C: the functions of skein.hpp with a handle and error codes.
///
///     skein_mesh* mesh = skein_mesh_create();
///     skein_set_vertices(mesh, n, coords, NULL);            // arrays are copied
///     skein_set_tetrahedra(mesh, n_tets, tets, NULL);
///     skein_set_triangles(mesh, n_triangles, triangles, patches);
///     skein_set_target(mesh, SKEIN_SIZE, sizes);
///     if (skein_adapt(comm, mesh, NULL, NULL) != SKEIN_OK) fputs(skein_last_error(), stderr);
///     use(skein_count_vertices(mesh), skein_vertices(mesh), ...);
///     skein_mesh_destroy(mesh);
///
/// Functions return SKEIN_OK or another skein_status; no exception crosses them. skein_adapt() is collective, returns
/// the same on all ranks (but for SKEIN_ALONE) and follows the rules of skein.hpp; nothing else communicates. All
/// numbers count from 0. Arrays may be NULL when they are of 0 items; references may always be NULL: all 0.
#pragma once
#include <mpi.h>
#include <stdint.h>

#include "skein/export.h"
#include "skein/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What a function returns; skein::ErrorCode says more.
typedef enum skein_status {
  SKEIN_OK = 0,            ///< done
  SKEIN_INVALID_MESH = 1,  ///< the mesh given is not valid
  SKEIN_USAGE = 2,         ///< an option or an argument makes no sense
  SKEIN_INPUT = 3,         ///< a metric, a size or a field is not valid, or does not fit the mesh
  SKEIN_INTERNAL = 5,      ///< out of memory, or a bug of Skein
  SKEIN_CANCELLED = 6,     ///< the progress function has asked to stop
  SKEIN_ALONE = 7          ///< this rank alone failed; the others may wait for it: end the run (MPI_Abort)
} skein_status;

/// What the numbers of skein_set_target() are.
typedef enum skein_target {
  SKEIN_METRIC = 0,    ///< 6 per vertex: m11 m12 m22 m13 m23 m33, 1/length^2
  SKEIN_SIZE = 1,      ///< 1 per vertex: wanted length of edges
  SKEIN_FIELD = 2,     ///< 1 per vertex: a solution; needs skein_options.complexity, elements or vertices
  SKEIN_OWN_SIZES = 3  ///< none: the mesh keeps its own sizes, and is improved
} skein_target;

/// How points are created.
typedef enum skein_points {
  SKEIN_POINTS_OF_METHOD = -1,  ///< as the method has it: the default
  SKEIN_POINTS_EDGES = 0,       ///< along long edges
  SKEIN_POINTS_CENTROIDS = 1    ///< at centroids of large tetrahedra
} skein_points;

/// How vertices are moved.
typedef enum skein_smoothing {
  SKEIN_SMOOTHING_OF_METHOD = -1,  ///< as the method has it: the default
  SKEIN_SMOOTHING_QUALITY = 0,     ///< to the best quality of their elements
  SKEIN_SMOOTHING_SPRINGS = 1      ///< by springs along their edges
} skein_smoothing;

/// What the progress function is told when a phase begins and when it has ended.
typedef struct skein_progress {
  const char* phase;  ///< such as "round 1: adapt"; valid during the call
  int finished;       ///< 0: the phase begins; 1: it has ended
  double seconds;     ///< since skein_adapt() was called
  int64_t tets;       ///< tetrahedra of all ranks at the end of the phase
} skein_progress;

/// Options of skein_adapt(); the same on all ranks. To be filled by skein_options_init() before any is changed.
typedef struct skein_options {
  double complexity;          ///< scale the metric to this complexity; 0: as it is
  double elements;            ///< in place of complexity: scale the metric to so many tetrahedra; 0: not given
  double vertices;            ///< the same by the number of vertices
  double aspect_max;          ///< largest over smallest edge length at a vertex, at least 1; 0: no bound
  double h_min;               ///< smallest edge length; 0: no bound
  double h_max;               ///< largest edge length; infinity: no bound
  double norm;                ///< with SKEIN_FIELD: L^p norm of the error, p >= 1 or infinity
  double gradation;           ///< growth of sizes per edge, > 1; 0: no bound; negative: 1.3 with SKEIN_SIZE, else none
  double ridge_angle;         ///< surface edges folded by more are ridges; degrees
  int surface;                ///< 0: boundary triangles are kept as they are
  const char* preset;         ///< name of a method, as skein::Options::preset; at most one of the three is not NULL
  const char* config;         ///< a method with its numbers as a text (TOML)
  const char* config_file;    ///< the same in a file, which rank 0 reads
  skein_points points;        ///< how points are created
  skein_smoothing smoothing;  ///< how vertices are moved
  int rounds;                 ///< rounds over the ranks
  int threads;                ///< threads in each rank
  int return_metric;          ///< not 0: skein_metric() is wanted
  /// May be NULL; returns 0 to stop. As skein::Options::progress.
  int (*progress)(const skein_progress* now, void* data);
  void* progress_data;  ///< handed to `progress`
} skein_options;

/// What skein_adapt() did; the same on all ranks. As skein::Report.
typedef struct skein_report {
  int64_t vertices_in;  ///< of the mesh given, over all ranks
  int64_t tets_in;      ///< of the mesh given
  int64_t vertices;     ///< of the new mesh
  int64_t tets;         ///< of the new mesh
  double complexity;    ///< of the metric on the new mesh
  double unit_edges;    ///< per cent of edges with a metric length in [1/sqrt 2, sqrt 2]
  double quality_min;   ///< metric mean ratio of the worst tetrahedron
  double quality_mean;  ///< of all
  double seconds;       ///< wall time on the slowest rank
} skein_report;

/// A rank's share of a distributed mesh with target and fields: in slices (skein::SlicedMesh), or in parts
/// (skein::PartitionedMesh) once it has skein_set_local_to_global().
typedef struct skein_mesh skein_mesh;

/// The version of the library, such as "0.1.0".
SKEIN_EXPORT const char* skein_version(void);
/// The text of the last error of this thread: one line; empty when there was none. Valid until the next error.
SKEIN_EXPORT const char* skein_last_error(void);
/// Fills in the defaults.
SKEIN_EXPORT void skein_options_init(skein_options* options);

/// An empty mesh; NULL when memory is short.
SKEIN_EXPORT skein_mesh* skein_mesh_create(void);
/// Frees it; NULL is fine.
SKEIN_EXPORT void skein_mesh_destroy(skein_mesh* mesh);

/// \name What goes in: each copies its arrays and replaces what was there
/// \{

/// n vertices of this rank: 3 coordinates each. To be called before target, fields and local-to-global numbers, which
/// it removes.
SKEIN_EXPORT int skein_set_vertices(skein_mesh* mesh, int64_t n, const double* coords, const int32_t* refs);
/// One global number per vertex: makes it a mesh in parts, where all other numbers are local ones.
SKEIN_EXPORT int skein_set_local_to_global(skein_mesh* mesh, const int64_t* numbers);
/// n tetrahedra of 4 vertices each.
SKEIN_EXPORT int skein_set_tetrahedra(skein_mesh* mesh, int64_t n, const int64_t* verts, const int32_t* refs);
/// n triangles of 3 vertices each.
SKEIN_EXPORT int skein_set_triangles(skein_mesh* mesh, int64_t n, const int64_t* verts, const int32_t* refs);
/// n edges of 2 vertices each.
SKEIN_EXPORT int skein_set_edges(skein_mesh* mesh, int64_t n, const int64_t* verts, const int32_t* refs);
/// Vertex numbers.
SKEIN_EXPORT int skein_set_corners(skein_mesh* mesh, int64_t n, const int64_t* verts);
/// Vertex numbers.
SKEIN_EXPORT int skein_set_required_vertices(skein_mesh* mesh, int64_t n, const int64_t* verts);
/// Edge numbers.
SKEIN_EXPORT int skein_set_ridges(skein_mesh* mesh, int64_t n, const int64_t* edges);
/// Edge numbers.
SKEIN_EXPORT int skein_set_required_edges(skein_mesh* mesh, int64_t n, const int64_t* edges);
/// Triangle numbers.
SKEIN_EXPORT int skein_set_required_triangles(skein_mesh* mesh, int64_t n, const int64_t* triangles);
/// Tetrahedron numbers.
SKEIN_EXPORT int skein_set_required_tetrahedra(skein_mesh* mesh, int64_t n, const int64_t* tets);
/// What the mesh shall be like: 6 or 1 numbers per vertex; of SKEIN_OWN_SIZES none (NULL).
SKEIN_EXPORT int skein_set_target(skein_mesh* mesh, skein_target kind, const double* values);
/// What is carried to the new mesh: `width` numbers per vertex.
SKEIN_EXPORT int skein_set_fields(skein_mesh* mesh, int width, const double* values);
/// \}

/// Adapts the mesh in place: afterwards it is the new one, in the same convention, with the carried fields and without
/// a target. Collective. `options` and `report` may be NULL. After an error the mesh is empty.
SKEIN_EXPORT int skein_adapt(MPI_Comm comm, skein_mesh* mesh, const skein_options* options, skein_report* report);

/// \name What comes out: counts, and arrays that belong to the mesh and are valid until it is changed
/// \{
SKEIN_EXPORT int64_t skein_count_vertices(const skein_mesh* mesh);             ///< of this rank
SKEIN_EXPORT int64_t skein_count_tetrahedra(const skein_mesh* mesh);           ///< of this rank
SKEIN_EXPORT int64_t skein_count_triangles(const skein_mesh* mesh);            ///< of this rank
SKEIN_EXPORT int64_t skein_count_edges(const skein_mesh* mesh);                ///< of this rank
SKEIN_EXPORT int64_t skein_count_corners(const skein_mesh* mesh);              ///< of this rank
SKEIN_EXPORT int64_t skein_count_required_vertices(const skein_mesh* mesh);    ///< of this rank
SKEIN_EXPORT int64_t skein_count_ridges(const skein_mesh* mesh);               ///< of this rank
SKEIN_EXPORT int64_t skein_count_required_edges(const skein_mesh* mesh);       ///< of this rank
SKEIN_EXPORT int64_t skein_count_required_triangles(const skein_mesh* mesh);   ///< of this rank
SKEIN_EXPORT int64_t skein_count_required_tetrahedra(const skein_mesh* mesh);  ///< of this rank
SKEIN_EXPORT const double* skein_vertices(const skein_mesh* mesh);             ///< 3 per vertex
SKEIN_EXPORT const int32_t* skein_vertex_refs(const skein_mesh* mesh);         ///< 1 per vertex
SKEIN_EXPORT const int64_t* skein_local_to_global(const skein_mesh* mesh);     ///< 1 per vertex; NULL for slices
SKEIN_EXPORT const int64_t* skein_tetrahedra(const skein_mesh* mesh);          ///< 4 per tetrahedron
SKEIN_EXPORT const int32_t* skein_tetrahedron_refs(const skein_mesh* mesh);    ///< 1 per tetrahedron
SKEIN_EXPORT const int64_t* skein_triangles(const skein_mesh* mesh);           ///< 3 per triangle
SKEIN_EXPORT const int32_t* skein_triangle_refs(const skein_mesh* mesh);       ///< 1 per triangle
SKEIN_EXPORT const int64_t* skein_edges(const skein_mesh* mesh);               ///< 2 per edge
SKEIN_EXPORT const int32_t* skein_edge_refs(const skein_mesh* mesh);           ///< 1 per edge
SKEIN_EXPORT const int64_t* skein_corners(const skein_mesh* mesh);             ///< vertex numbers
SKEIN_EXPORT const int64_t* skein_required_vertices(const skein_mesh* mesh);   ///< vertex numbers
SKEIN_EXPORT const int64_t* skein_ridges(const skein_mesh* mesh);              ///< edge numbers
SKEIN_EXPORT const int64_t* skein_required_edges(const skein_mesh* mesh);       ///< edge numbers
SKEIN_EXPORT const int64_t* skein_required_triangles(const skein_mesh* mesh);   ///< triangle numbers
SKEIN_EXPORT const int64_t* skein_required_tetrahedra(const skein_mesh* mesh);  ///< tetrahedron numbers
SKEIN_EXPORT int skein_field_width(const skein_mesh* mesh);                    ///< numbers per vertex in skein_fields()
SKEIN_EXPORT const double* skein_fields(const skein_mesh* mesh);               ///< the carried fields
SKEIN_EXPORT const double* skein_metric(const skein_mesh* mesh);  ///< 6 per vertex; NULL without return_metric
/// \}

#ifdef __cplusplus
}
#endif
