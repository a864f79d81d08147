// How far a mesh may be cut, and the metric of a step of growth.
#include "adapt/grow.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "base/tensor.hpp"
#include "dist/partition.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// A cube of n^3 cells; edge length h(x) along all axes.
template <class Size>
DistMesh make(const Comm& comm, int n, Size&& h) {
  return with_metric(comm, cube(n), [&](Vec3 x) { return isotropic(-2 * std::log(h(x))); });
}
double sum(const Comm& comm, const std::vector<double>& v) {
  return comm.sum(std::accumulate(v.begin(), v.end(), 0.0));
}

TEST(Grow, LimitsFollowFromTheTetrahedraThatShareTheWork) {
  const Comm& comm = world();
  const int per_rank = 40000;
  std::vector<double> work(per_rank, 10.0);
  EXPECT_EQ(cut_limits(comm, work, comm.size()).able, comm.size());
  EXPECT_EQ(cut_limits(comm, work, comm.size()).wanted, comm.size());
  // Ten tetrahedra become nearly all of the mesh.
  if (comm.is_root()) std::fill_n(work.begin(), 10, 1e9);
  EXPECT_EQ(cut_limits(comm, work, comm.size()).able, 1);
  EXPECT_EQ(cut_limits(comm, work, comm.size()).wanted, comm.size());
  EXPECT_EQ(cut_limits(comm, std::vector<double>{}, comm.size()).able, 1);
  EXPECT_EQ(cut_limits(comm, std::vector<double>{}, comm.size()).wanted, 1);
}

TEST(Grow, BoundsWhatComesOfTheMesh) {
  const Comm& comm = world();
  DistMesh dist = make(comm, 8, [](Vec3) { return 0.01; });
  const std::vector<double> work = predicted_elements(dist.mesh);
  constexpr double kGrowth = 8;
  const auto tets = static_cast<double>(dist.global_tets);
  ASSERT_GT(sum(comm, work), 100 * kGrowth * tets);
  bound_growth(comm, dist, work, kGrowth);
  const double bounded = sum(comm, predicted_elements(dist.mesh));
  EXPECT_LT(bounded, 2 * kGrowth * tets);
  EXPECT_GT(bounded, 2 * tets);
  reconcile(comm, dist);  // the same bits on all copies
}

TEST(Grow, IsNeverStricterAndLeavesWhatGrowsLittle) {
  const Comm& comm = world();
  DistMesh dist = make(comm, 8, [](Vec3 x) { return x.x < 0.5 ? 0.12 : 0.005; });
  const auto given = dist.mesh.log_metric;
  bound_growth(comm, dist, predicted_elements(dist.mesh), 8);
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const SymTensor &was = given[v], &is = dist.mesh.log_metric[v];
    EXPECT_LE(is.xx, was.xx + 1e-12);
    EXPECT_LE(is.yy, was.yy + 1e-12);
    EXPECT_LE(is.zz, was.zz + 1e-12);
    if (dist.mesh.coords[v].x > 0.3) continue;
    EXPECT_EQ(is, was);
  }
}

}  // namespace
}  // namespace skein::test
