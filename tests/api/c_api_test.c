/* The C functions: a cube of six tetrahedra per cell, adapted twice, and what happens when something is wrong. */
#include <math.h>
#include <mpi.h>
#include <skein/skein.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static void expect(int holds, const char* what, int line) {
  if (holds) return;
  ++failures;
  fprintf(stderr, "c_api_test.c:%d: %s (last error: %s)\n", line, what, skein_last_error());
}
#define EXPECT(condition) expect((condition) ? 1 : 0, #condition, __LINE__)

enum { N = 3, SIDE = N + 1, VERTS = SIDE * SIDE * SIDE, TETS = 6 * N * N * N };

static double coords[3 * VERTS];
static double sizes[VERTS];
static int64_t numbers[VERTS];
static int64_t tets[4 * TETS];

static void make_cube(void) {
  static const int64_t step[3] = {1, SIDE, SIDE * SIDE};
  static const int way[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  int64_t* tet = tets;
  for (int v = 0; v < VERTS; ++v) {
    coords[3 * v] = v % SIDE / (double)N;
    coords[3 * v + 1] = v / SIDE % SIDE / (double)N;
    coords[3 * v + 2] = v / SIDE / SIDE / (double)N;
    sizes[v] = 0.15;
    numbers[v] = v;
  }
  for (int cell = 0; cell < N * N * N; ++cell) {
    const int64_t a = cell % N + cell / N % N * SIDE + cell / N / N * SIDE * SIDE;
    for (int w = 0; w < 6; ++w, tet += 4) {
      const int64_t b = a + step[way[w][0]], c = b + step[way[w][1]], d = c + step[way[w][2]];
      tet[0] = a, tet[1] = w < 3 ? b : c, tet[2] = w < 3 ? c : b, tet[3] = d;
    }
  }
}

/* All of the cube on rank 0; in parts if `parts`. */
static skein_mesh* cube(int rank, int parts) {
  skein_mesh* mesh = skein_mesh_create();
  const int64_t verts = rank == 0 ? VERTS : 0, n = rank == 0 ? TETS : 0;
  EXPECT(skein_set_vertices(mesh, verts, coords, NULL) == SKEIN_OK);
  if (parts) EXPECT(skein_set_local_to_global(mesh, numbers) == SKEIN_OK);
  EXPECT(skein_set_tetrahedra(mesh, n, tets, NULL) == SKEIN_OK);
  EXPECT(skein_set_target(mesh, SKEIN_SIZE, sizes) == SKEIN_OK);
  EXPECT(skein_set_fields(mesh, 3, coords) == SKEIN_OK);
  return mesh;
}

static int count_phases(const skein_progress* now, void* data) {
  if (now->finished) ++*(int*)data;
  return 1;
}
static int stop(const skein_progress* now, void* data) {
  (void)data;
  return strcmp(now->phase, "metric") != 0;
}

static void test_adapt(int rank, int parts) {
  skein_mesh* mesh = cube(rank, parts);
  skein_options options;
  skein_report report;
  int phases = 0;
  skein_options_init(&options);
  options.progress = count_phases;
  options.progress_data = &phases;
  options.return_metric = 1;
  EXPECT(skein_adapt(MPI_COMM_WORLD, mesh, &options, &report) == SKEIN_OK);
  EXPECT(phases > 5);
  EXPECT(report.tets_in == TETS && report.tets > 1000 && report.quality_min > 0.1);
  EXPECT((skein_local_to_global(mesh) != NULL) == (parts && skein_count_vertices(mesh) > 0));
  EXPECT(skein_field_width(mesh) == 3);
  const double* x = skein_vertices(mesh);
  const double* f = skein_fields(mesh);
  double worst = 0;
  for (int64_t i = 0; i < 3 * skein_count_vertices(mesh); ++i) worst = fmax(worst, fabs(x[i] - f[i]));
  EXPECT(worst < 1e-14);
  int64_t all = skein_count_tetrahedra(mesh);
  for (int64_t i = 0; i < 4 * all; ++i) EXPECT(skein_tetrahedra(mesh)[i] >= 0);
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT(all == report.tets);
  EXPECT(skein_count_vertices(mesh) == 0 || fabs(skein_metric(mesh)[0] - 1 / (0.15 * 0.15)) < 1e-6);
  EXPECT(skein_count_triangles(mesh) == 0 || skein_triangle_refs(mesh)[0] == 1);
  skein_mesh_destroy(mesh);
}

static void test_errors(int rank) {
  skein_mesh* mesh = skein_mesh_create();
  EXPECT(skein_set_vertices(mesh, -1, NULL, NULL) == SKEIN_USAGE);
  EXPECT(skein_set_vertices(mesh, 1, NULL, NULL) == SKEIN_USAGE);
  EXPECT(skein_set_vertices(NULL, 0, NULL, NULL) == SKEIN_USAGE);
  EXPECT(skein_set_vertices(mesh, 0, NULL, NULL) == SKEIN_OK);
  EXPECT(skein_adapt(MPI_COMM_WORLD, mesh, NULL, NULL) == SKEIN_INPUT);
  EXPECT(strcmp(skein_last_error(), "the mesh has no tetrahedra") == 0);
  skein_mesh_destroy(mesh);
  skein_mesh_destroy(NULL);

  mesh = cube(rank, 0);
  sizes[5] = -1;
  EXPECT(skein_set_target(mesh, SKEIN_SIZE, sizes) == SKEIN_OK);
  sizes[5] = 0.15;
  EXPECT(skein_adapt(MPI_COMM_WORLD, mesh, NULL, NULL) == SKEIN_INPUT);
  EXPECT(strstr(skein_last_error(), "vertex 5 is -1") != NULL);
  EXPECT(skein_count_vertices(mesh) == 0);
  skein_mesh_destroy(mesh);

  mesh = cube(rank, 1);
  skein_options options;
  skein_options_init(&options);
  options.progress = stop;
  EXPECT(skein_adapt(MPI_COMM_WORLD, mesh, &options, NULL) == SKEIN_CANCELLED);
  skein_mesh_destroy(mesh);
}

/* A method by its name and as a text: the same mesh, and another one than without. */
static void test_methods(int rank) {
  static const char* const presets[] = {"chapter", NULL, NULL, "no such method"};
  static const char* const configs[] = {NULL, "preset = \"chapter\"", NULL, NULL};
  skein_report reports[3];
  for (int i = 0; i < 4; ++i) {
    skein_mesh* mesh = cube(rank, 0);
    skein_options options;
    skein_options_init(&options);
    options.preset = presets[i];
    options.config = configs[i];
    EXPECT(skein_adapt(MPI_COMM_WORLD, mesh, &options, i < 3 ? &reports[i] : NULL) == (i < 3 ? SKEIN_OK : SKEIN_USAGE));
    skein_mesh_destroy(mesh);
  }
  EXPECT(reports[0].tets == reports[1].tets && reports[0].quality_mean == reports[1].quality_mean);
  EXPECT(reports[0].quality_mean != reports[2].quality_mean);
}

int main(int argc, char** argv) {
  int rank = 0;
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  EXPECT(strcmp(skein_version(), SKEIN_VERSION) == 0);
  make_cube();
  test_adapt(rank, 0);
  test_adapt(rank, 1);
  test_methods(rank);
  test_errors(rank);
  MPI_Allreduce(MPI_IN_PLACE, &failures, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  MPI_Finalize();
  return failures == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
