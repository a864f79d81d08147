// A solver that adapts its mesh as it goes, in memory: a cloud drifts through a cube, and the mesh follows it.
//
// The solver has a communicator of its own, of up to two ranks; what other ranks of the run do is nobody's business.
#include <cmath>
#include <cstdio>
#include <skein/skein.hpp>

#include "advection.hpp"
#include "cube.hpp"

namespace {

constexpr int kCycles = 5;
constexpr double kCycleTime = 0.08;
constexpr std::array<double, 3> kVelocity{1, 0.5, 0.25};

/// A smooth cloud of radius 0.2.
double cloud(const std::array<double, 3>& x) {
  const double r = std::hypot(x[0] - 0.3, x[1] - 0.35, x[2] - 0.4) / 0.2;
  return r < 1 ? (1 + std::cos(3.14159265358979 * r)) / 2 : 0;
}

void solve(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  skein::PartitionedMesh mesh = cube(comm, 12);
  std::vector<double> density;
  for (const auto& x : mesh.coords) density.push_back(cloud(x));

  skein::Options options;
  options.complexity = 2000;  // about 20,000 tetrahedra
  options.h_min = 0.01, options.h_max = 0.2;
  Advection advection(comm, mesh, kVelocity);
  for (int cycle = 1; cycle <= kCycles; ++cycle) {
    advection.advance(density, kCycleTime);
    const double before = advection.mass(density);

    // The mesh is adapted to the density, and carries it. The old arrays are not needed any more.
    skein::Target target = skein::Target::field(density);
    auto fine = skein::adapt(comm, std::move(mesh), std::move(target), {1, std::move(density)}, options);
    mesh = std::move(fine.mesh);
    density = std::move(fine.fields.values);

    advection = Advection(comm, mesh, kVelocity);
    const double after = advection.mass(density);
    if (rank > 0) continue;
    std::printf(
        "cycle %d: %lld tetrahedra, unit edges %.1f %%, least quality %.2f, mass %.6f, lost by the transfer %+.3f %%\n",
        cycle, static_cast<long long>(fine.report.tets), fine.report.unit_edges, fine.report.quality_min, after,
        100 * (before - after) / before);
  }
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm solver = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank < 2 ? 0 : MPI_UNDEFINED, rank, &solver);
  if (solver != MPI_COMM_NULL) {
    try {
      solve(solver);
    } catch (const skein::Error& e) {
      std::fprintf(stderr, "embed: %s\n", e.what());
      MPI_Abort(MPI_COMM_WORLD, static_cast<int>(e.code()));
    }
    MPI_Comm_free(&solver);
  }
  MPI_Finalize();
}
