// Recovered derivatives: where they are exact, that they converge, and that the ranks do not matter.
#include "solution/hessian.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "tests/support/dealt_cube.hpp"

namespace skein {
namespace {

using test::DealtCube;
using test::Lattice;
using test::sample;
using test::world;

double difference(const SymTensor& a, const SymTensor& b) {
  const SymTensor d = a + -1.0 * b;
  return std::max({std::abs(d.xx), std::abs(d.xy), std::abs(d.yy), std::abs(d.xz), std::abs(d.yz), std::abs(d.zz)});
}

struct Recovered {
  DistMesh dist;
  std::vector<Vec3> gradient;
  std::vector<SymTensor> hessian;
};

template <class F>
Recovered recover(const Comm& comm, const DealtCube& cube, F f) {
  Recovered r{cube.part(comm), {}, {}};
  const Halo halo(comm, r.dist.sharing);
  const auto scalar = sample(r.dist, f);
  r.gradient = recover_gradient(comm, r.dist, halo, scalar);
  r.hessian = recover_hessian(comm, r.dist, halo, scalar);
  return r;
}

/// Largest difference to the exact Hessian at vertices `from` cells and more away from the hull.
template <class F, class H>
double worst_hessian(const DealtCube& cube, int from, F f, H exact) {
  const auto r = recover(world(), cube, f);
  double worst = 0;
  for (const VertId v : IdRange<VertId>(r.hessian.size())) {
    if (cube.depth(num(r.dist.vert2gid[v])) < from) continue;
    worst = std::max(worst, difference(r.hessian[idx(v)], exact(r.dist.mesh.coords[v])));
  }
  return world().max(worst);
}

const SymTensor kBend{4, -1, 0.5, 2, 0.25, -3};
double quadratic(Vec3 x) { return 0.5 * quad(kBend, x) + 3 * x.x - 2 * x.y + x.z + 1e3; }
double waves(Vec3 x) { return std::sin(2 * x.x + x.y) + std::cos(x.y - 3 * x.z); }
SymTensor bend_of_waves(Vec3 x) {
  const double s = -std::sin(2 * x.x + x.y), c = -std::cos(x.y - 3 * x.z);
  return {4 * s, 2 * s, s + c, 0, -3 * c, 9 * c};
}

TEST(Hessian, linear_functions_have_their_gradient_everywhere_and_no_curvature) {
  for (const double shake : {0.0, 0.2}) {
    const auto r = recover(world(), DealtCube{6, shake}, [](Vec3 x) { return 3 * x.x - 2 * x.y + 0.5 * x.z + 7; });
    for (const Vec3 g : r.gradient) EXPECT_LT(norm(g - Vec3{3, -2, 0.5}), 1e-12);
    for (const auto& h : r.hessian) EXPECT_LT(difference(h, {}), 1e-10);
  }
}

TEST(Hessian, constants_have_no_derivative_at_all) {
  const auto r = recover(world(), DealtCube{4, 0.2}, [](Vec3) { return 1e8 + 0.1; });
  for (const auto& h : r.hessian) EXPECT_EQ(h, SymTensor{});
}

TEST(Hessian, quadratic_functions_are_exact_two_cells_inside_a_regular_mesh) {
  EXPECT_LT(worst_hessian(DealtCube{8, 0}, 2, quadratic, [](Vec3) { return kBend; }), 1e-9);
}

TEST(Hessian, is_within_a_bound_of_the_truth_up_to_the_hull) {
  const auto exact = [](Vec3) { return kBend; };
  EXPECT_LT(worst_hessian(DealtCube{8, 0}, 0, quadratic, exact), 0.15 * 4);
  EXPECT_LT(worst_hessian(DealtCube{8, 0.2}, 0, quadratic, exact), 0.3 * 4);
}

TEST(Hessian, converges_inside_with_the_square_of_the_cell) {
  const double coarse = worst_hessian(DealtCube{8, 0}, 2, waves, bend_of_waves);
  const double fine = worst_hessian(DealtCube{16, 0}, 4, waves, bend_of_waves);
  EXPECT_LT(fine, 0.35 * coarse);
  EXPECT_LT(fine, 0.1 * 9);
}

TEST(Hessian, number_of_ranks_changes_rounding_only_and_copies_are_equal) {
  const DealtCube cube{7, 0.2};
  const auto alone = recover(Comm::self(), cube, waves);
  const auto r = recover(world(), cube, waves);
  std::vector<double> numbers;
  for (const VertId v : IdRange<VertId>(r.hessian.size())) {
    const auto& h = r.hessian[idx(v)];
    EXPECT_LT(difference(h, alone.hessian[idx(r.dist.vert2gid[v])]), 1e-10);
    for (const double x : {h.xx, h.xy, h.yy, h.xz, h.yz, h.zz}) numbers.push_back(x);
  }
  auto lowest = numbers;
  Halo(world(), r.dist.sharing).copy_from_owner(std::span(lowest), 6);
  EXPECT_EQ(lowest, numbers);
}

TEST(Hessian, values_that_are_not_finite_are_refused_with_their_vertex) {
  const DealtCube cube{4, 0};
  const DistMesh dist = cube.part(world());
  const Halo halo(world(), dist.sharing);
  const std::int64_t bad = Lattice{cube.n}.number(2, 2, 3);
  std::vector<double> scalar(dist.mesh.vert_slots(), 1.0);
  for (const VertId v : IdRange<VertId>(scalar.size())) {
    if (dist.vert2gid[v] == GlobalId{bad}) scalar[idx(v)] = std::numeric_limits<double>::quiet_NaN();
  }
  try {
    static_cast<void>(recover_hessian(world(), dist, halo, scalar));
    ADD_FAILURE() << "not refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInput);
    EXPECT_NE(std::string(e.what()).find("vertex " + std::to_string(bad + 1)), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace skein
