// Lengths and quality against their definitions.
#include "metric/measure.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "metric/mesh_metric.hpp"
#include "tests/metric/tensors.hpp"

namespace skein::test {
namespace {

/// Vertices of the regular tetrahedron of side 1.
constexpr double kRoot3 = 1.7320508075688772, kRoot6 = 2.449489742783178;
const std::array<Vec3, 4> kUnit{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5, kRoot3 / 2, 0},
                                Vec3{0.5, kRoot3 / 6, kRoot6 / 3}};

/// m^(-1/2) x: what has length |x| in m.
Vec3 stretch(const SymTensor& m, Vec3 x) {
  Eigen e = eigen(m);
  for (auto& l : e.value) l = 1 / std::sqrt(l);
  return mul(compose(e), x);
}

RC_GTEST_PROP(LogMean, IsTheLogarithmicMean, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-6, 6);
  const double a = std::exp(any(random)), b = a * std::exp(any(random) * *rc::gen::element(1.0, 0.1, 1e-3));
  const double exact = std::abs(b / a - 1) < 1e-6 ? 0.5 * (a + b) : (a - b) / std::log(a / b);
  RC_ASSERT(std::abs(log_mean(a, b) - exact) <= 1e-4 * exact);
  RC_ASSERT(std::abs(log_mean(a, b) - log_mean(b, a)) <= 1e-15 * exact);
  RC_ASSERT(log_mean(a, b) >= std::min(a, b) * (1 - 1e-4) && log_mean(a, b) <= 0.5 * (a + b) * (1 + 1e-15));
}

TEST(LogMean, AtItsEnds) {
  EXPECT_EQ(log_mean(2, 2), 2);
  EXPECT_EQ(log_mean(0, 0), 0);
  EXPECT_EQ(log_mean(0, 1), 0);
  EXPECT_NEAR(log_mean(1, 1e6), (1e6 - 1) / std::log(1e6), 1e-6);
}

RC_GTEST_PROP(EdgeLength, IsThatOfTheMetricWhenBothEndsAgree, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const SymTensor m = random_metric(random, 0.01, *rc::gen::element(1.0, 100.0, 1e6));
  const Vec3 e = 3.7 * random_frame(random)[0];
  RC_ASSERT(std::abs(edge_length(m, m, e) - std::sqrt(quad(m, e))) <= 1e-14 * std::sqrt(quad(m, e)));
}

RC_GTEST_PROP(Quality, IsOneForTheUnitTetrahedronOfAnyMetric, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const double anisotropy = std::pow(10.0, *rc::gen::inRange(0, 7));
  const SymTensor m = random_metric(random, *rc::gen::element(1e-4, 1.0, 1e3), anisotropy);
  const VertMetric vm = vert_metric_from_log(log(m));
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = stretch(m, kUnit[i]);
  // e'Me is known to rounding at the size of the largest eigenvalue.
  const double tolerance = 1e-12 + 1e-14 * anisotropy * anisotropy;
  RC_ASSERT(std::abs(quality_cubed(x[0], x[1], x[2], x[3], vm, vm, vm, vm) - 1) < tolerance);
  RC_ASSERT(std::abs(quality_cubed(x[0], x[2], x[1], x[3], vm, vm, vm, vm) + 1) < tolerance);
  const double s = *rc::gen::element(0.25, 3.0);  // size does not count
  RC_ASSERT(std::abs(quality_cubed(s * x[0], s * x[1], s * x[2], s * x[3], vm, vm, vm, vm) - 1) < tolerance);
}

RC_GTEST_PROP(MeshMetric, KnowsTheDeterminantAtAnyAnisotropy, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  Eigen e;
  e.vector = random_frame(random);
  std::uniform_real_distribution<double> any(-13.8, 13.8);
  for (auto& l : e.value) l = any(random);
  const double exact = std::exp(0.5 * (e.value[0] + e.value[1] + e.value[2]));
  RC_ASSERT(std::abs(vert_metric_from_log(compose(e)).sqrt_det - exact) <= 1e-13 * exact);
}

/// Metrics of one determinant that are turned against each other: which of them counts is the same in any order.
TEST(Quality, DoesNotHangOnTheOrderOfEquallyStrictMetrics) {
  const auto turned = [](double xy, double xz) {
    VertMetric m = vert_metric({5, xy, 5, xz, 0, 4});
    m.sqrt_det = 3;
    m.order_key = order_key_of(m.m, 3);
    return m;
  };
  const std::array<VertMetric, 4> m{turned(2, 1), turned(-2, 1), turned(2, -1), turned(-2, -1)};
  const auto at = [&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
    return quality_cubed(kUnit[i], kUnit[j], kUnit[k], kUnit[l], m[i], m[j], m[k], m[l]);
  };
  for (const auto& o : {std::array<std::size_t, 4>{1, 2, 0, 3}, {0, 2, 3, 1}, {3, 2, 1, 0}, {1, 0, 3, 2}})
    EXPECT_NEAR(at(o[0], o[1], o[2], o[3]), at(0, 1, 2, 3), 1e-12);
}

RC_GTEST_PROP(Quality, IsAtMostOneAndFollowsTheStrictestMetric, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  std::normal_distribution<double> any;
  std::array<Vec3, 4> x;
  std::array<VertMetric, 4> m;
  for (std::size_t i = 0; i < 4; ++i) {
    x[i] = {any(random), any(random), any(random)};
    m[i] = vert_metric(random_metric(random, 0.1 + 0.2 * static_cast<double>(i), 10));
  }
  const double q = quality_cubed(x[0], x[1], x[2], x[3], m[0], m[1], m[2], m[3]);
  RC_ASSERT(q <= 1 + 1e-12 && q >= -1 - 1e-12);
  std::size_t strictest = 0;
  for (std::size_t i = 1; i < 4; ++i) strictest = m[i].sqrt_det > m[strictest].sqrt_det ? i : strictest;
  const VertMetric& s = m[strictest];
  RC_ASSERT(q == quality_cubed(x[0], x[1], x[2], x[3], s, s, s, s));
  // An even permutation gives the same up to rounding, an odd one the negative.
  const double even = quality_cubed(x[1], x[2], x[0], x[3], m[1], m[2], m[0], m[3]);
  const double odd = quality_cubed(x[1], x[0], x[2], x[3], m[1], m[0], m[2], m[3]);
  RC_ASSERT(std::abs(even - q) <= 1e-11 && std::abs(odd + q) <= 1e-11);
}

TEST(Quality, FlatAndInverted) {
  const VertMetric m = vert_metric(isotropic(1));
  EXPECT_EQ(quality_cubed({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, m, m, m, m), 0);
  EXPECT_LT(quality_cubed({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}, m, m, m, m), 0);
  EXPECT_EQ(quality(-0.5), 0);
  EXPECT_NEAR(quality(0.125), 0.5, 1e-15);
}

}  // namespace
}  // namespace skein::test
