// Metrics that stretch the elements of a mesh by factors of hundreds and more.
#include "adapt/stretch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "adapt/adapt.hpp"
#include "dist/partition.hpp"
#include "dist/reconcile.hpp"
#include "metric/complexity.hpp"
#include "metric/mesh_metric.hpp"
#include "report/statistics.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// Size h across layers whose normal is turned by `angle` from the x axis, and `along` in them.
SymTensor log_layers(double h, double along, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), a = -2 * std::log(h), b = -2 * std::log(along);
  return {c * c * a + s * s * b, c * s * (a - b), s * s * a + c * c * b, 0, 0, b};
}
DistMesh cube_with(const Comm& comm, int n, const SymTensor& log_m) {
  return with_metric(comm, cube(n), [&](Vec3) { return log_m; });
}
StretchToDo to_do(const Comm& comm, DistMesh& dist, double bound) {
  measure_metric(dist.mesh);
  const StretchToDo out = stretch_to_do(comm, dist, predicted_elements(dist.mesh), bound);
  dist.mesh.metric = {};
  return out;
}

TEST(Stretch, IsNoneWhereSizesChangeAlikeInAllOrTwoDirections) {
  const Comm& comm = world();
  DistMesh fine = cube_with(comm, 4, isotropic(-2 * std::log(0.001)));
  EXPECT_EQ(to_do(comm, fine, 16).elements, 0);
  DistMesh coarse = cube_with(comm, 4, isotropic(-2 * std::log(10.0)));
  EXPECT_EQ(to_do(comm, coarse, 16).elements, 0);
  DistMesh needles = cube_with(comm, 4, SymTensor{9.2, 0, 9.2, 0, 0, 2.8});
  EXPECT_EQ(to_do(comm, needles, 16).elements, 0);
}

TEST(Stretch, IsSeenInAnyDirection) {
  const Comm& comm = world();
  for (const double angle : {0.0, 0.5}) {
    DistMesh dist = cube_with(comm, 4, log_layers(0.001, 0.5, angle));
    EXPECT_GT(to_do(comm, dist, 32).share, 0.99);
    EXPECT_GT(to_do(comm, dist, 32).excess, 1);
  }
}

TEST(Stretch, StepIsBoundedCoarserAndEqualOnAllCopies) {
  const Comm& comm = world();
  const SymTensor given = log_layers(1e-4, 0.5, 0.5);
  DistMesh dist = cube_with(comm, 4, given);
  const Method::Growth method;
  bound_stretch(comm, dist, method);
  const Vec3 across{std::cos(0.5), std::sin(0.5), 0};
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const SymTensor step = exp(dist.mesh.log_metric[v]), m = exp(given);
    // Cells of 1/4, of tetrahedra that are up to twice as long in one direction as in another.
    EXPECT_GT(1 / std::sqrt(quad(step, across)), 0.25 / method.stretch_step / 3);
    for (const Vec3 e : {across, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 1}}) {
      EXPECT_LE(quad(step, e), quad(m, e) * (1 + 1e-6));
    }
  }
  reconcile(comm, dist);  // the same bits on all copies
}

TEST(Stretch, LeavesWhatIsNearTheMesh) {
  const Comm& comm = world();
  const SymTensor given = log_layers(0.1, 0.25, 0.5);
  DistMesh dist = cube_with(comm, 4, given);
  bound_stretch(comm, dist, {});
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) EXPECT_EQ(dist.mesh.log_metric[v], given);
}

/// Adapts a cube of n^3 cells and expects a unit mesh with no more vertices than boundary layers of it explain.
void expect_unit_mesh(int n, double h, double along, double angle) {
  const Comm& comm = world();
  const SymTensor log_m = log_layers(h, along, angle);
  DistMesh dist = cube_with(comm, n, log_m);
  PhaseLog log(comm, PhaseLog::Output::kQuiet);
  adapt(comm, dist, {}, log);
  const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric);
  EXPECT_GT(s.length.unit_share, 88) << n << ' ' << h << ' ' << along << ' ' << angle;
  const double complexity = std::exp(log_sqrt_det(log_m));
  EXPECT_LT(static_cast<double>(s.tets), 15 * complexity);
  EXPECT_GT(static_cast<double>(s.tets), 6 * complexity);
}

TEST(Stretch, OneElementWide) { expect_unit_mesh(4, 0.002, 1, 0); }
TEST(Stretch, FromOneCell) { expect_unit_mesh(1, 0.002, 1, 0); }
TEST(Stretch, AcrossTheAxes) { expect_unit_mesh(4, 0.004, 1, 0.5); }
TEST(Stretch, SeveralElementsWide) { expect_unit_mesh(4, 0.001, 0.5, 0); }

}  // namespace
}  // namespace skein::test
