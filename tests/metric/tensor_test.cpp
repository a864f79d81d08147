// The algebra of tensors, up to anisotropy 1e6 (eigenvalues that differ by 1e12).
#include "base/tensor.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <vector>

#include "metric/batch.hpp"
#include "metric/mesh_metric.hpp"
#include "tests/metric/tensors.hpp"

namespace skein::test {
namespace {

double largest(const SymTensor& m) {
  return std::max({std::abs(m.xx), std::abs(m.xy), std::abs(m.yy), std::abs(m.xz), std::abs(m.yz), std::abs(m.zz)});
}
double anisotropy() { return std::pow(10.0, *rc::gen::inRange(0, 7)); }
double size() { return std::pow(10.0, *rc::gen::inRange(-6, 4)); }
Vec3 direction(std::mt19937& random) { return random_frame(random)[0]; }

RC_GTEST_PROP(Eigen, ReconstructsAndIsOrthonormal, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const SymTensor m = random_metric(random, size(), anisotropy());
  const Eigen e = eigen(m);
  RC_ASSERT(e.value[0] <= e.value[1] && e.value[1] <= e.value[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      RC_ASSERT(std::abs(dot(e.vector[i], e.vector[j]) - (i == j ? 1 : 0)) < 1e-13);
    }
  }
  RC_ASSERT(largest(compose(e) + -1.0 * m) <= 1e-13 * largest(m));
}

RC_GTEST_PROP(LogExp, ExpInvertsLog, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  // The smallest of the eigenvalues is known only to the rounding of the largest: 1e-16 * 1e12 at anisotropy 1e6.
  const double a = anisotropy();
  const SymTensor m = random_metric(random, size(), a);
  const SymTensor back = exp(log(m));
  RC_ASSERT(largest(back + -1.0 * m) <= 1e-12 * largest(m));
  const Vec3 e = direction(random);
  RC_ASSERT(std::abs(quad(back, e) - quad(m, e)) <= 1e-12 * quad(m, e) + 1e-15 * a * a * eigen(m).value[0]);
}

RC_GTEST_PROP(LogExp, LogInvertsExp, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  Eigen e;
  e.vector = random_frame(random);
  // Differences up to log(1e12) = 27.6.
  std::uniform_real_distribution<double> any(-13.8, 13.8);
  for (auto& l : e.value) l = any(random);
  const SymTensor l = compose(e);
  const auto [low, high] = std::minmax({e.value[0], e.value[1], e.value[2]});
  // Relative error of the smallest eigenvalue of exp(l), by rounding at the size of the largest.
  const double tolerance = 1e-13 + 1e-14 * std::exp(high - low);
  RC_ASSERT(largest(log(exp(l)) + -1.0 * l) <= tolerance);
}

RC_GTEST_PROP(LogExp, InLanesAsOneByOne, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  std::vector<SymTensor> logs;
  for (int i = *rc::gen::inRange(1, 20); i > 0; --i) logs.push_back(log(random_metric(random, size(), anisotropy())));
  if (seed % 4 == 0) logs.push_back(log(isotropic(3)));
  std::vector<VertMetric> got(logs.size());
  vert_metrics_from_logs(
      0, logs.size(), [&](std::size_t i) { return logs[i]; }, [&](std::size_t i, const VertMetric& m) { got[i] = m; });
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const VertMetric one = vert_metric_from_log(logs[i]);
    RC_ASSERT(largest(got[i].m + -1.0 * one.m) <= 1e-13 * largest(one.m));
    RC_ASSERT(std::abs(got[i].sqrt_det - one.sqrt_det) <= 1e-14 * one.sqrt_det);
  }
}

TEST(LogExp, OfTheIdentityAndIsotropic) {
  EXPECT_EQ(largest(log(isotropic(1))), 0);
  EXPECT_EQ(exp(SymTensor{}), isotropic(1));
  EXPECT_NEAR(log(isotropic(1e6)).xx, std::log(1e6), 1e-14);
}

RC_GTEST_PROP(Intersect, IsStricterThanBothAndNoStricterThanNeeded, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const double h = size(), ratio = std::pow(10.0, *rc::gen::inRange(-1, 2)), a = *rc::gen::element(1.0, 10.0, 1000.0);
  const SymTensor m1 = random_metric(random, h, a), m2 = random_metric(random, h * ratio, a);
  const SymTensor both = intersect(m1, m2);
  RC_ASSERT(is_positive_definite(both));
  const double slack = 1e-14 * a * a;
  for (int i = 0; i < 50; ++i) {
    const Vec3 e = direction(random);
    RC_ASSERT(quad(both, e) >= (1 - 1e-9 - slack) * quad(m1, e));
    RC_ASSERT(quad(both, e) >= (1 - 1e-9 - slack) * quad(m2, e));
    RC_ASSERT(quad(both, e) <= (1 + 1e-9 + slack) * (quad(m1, e) + quad(m2, e)));
  }
  // It touches: the determinant is not larger than that of the sum, and equal metrics stay as they are.
  RC_ASSERT(largest(intersect(m1, m1) + -1.0 * m1) <= (1e-12 + slack) * largest(m1));
}

RC_GTEST_PROP(Intersect, OfNestedMetricsIsTheStricter, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const SymTensor m = random_metric(random, size(), 100);
  for (const SymTensor& r : {intersect(m, 4.0 * m), intersect(4.0 * m, m)}) {
    RC_ASSERT(largest(r + -4.0 * m) <= 1e-9 * largest(m));
  }
}

RC_GTEST_PROP(ClampSizes, BoundsAllSizes, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const SymTensor m = random_metric(random, 1e-3, 1e6);
  const SymTensor c = clamp_sizes(m, 0.01, 10);
  for (int i = 0; i < 20; ++i) {
    const double h = 1 / std::sqrt(quad(c, direction(random)));
    RC_ASSERT(h >= 0.01 * (1 - 1e-9) && h <= 10 * (1 + 1e-6));
  }
  const SymTensor inside = random_metric(random, 0.1, 10);
  RC_ASSERT(largest(clamp_sizes(inside, 0.01, 100) + -1.0 * inside) <= 1e-12 * largest(inside));
}

TEST(PositiveDefinite, TellsWhatIsNot) {
  EXPECT_TRUE(is_positive_definite(isotropic(1e-9)));
  EXPECT_FALSE(is_positive_definite(SymTensor{}));
  EXPECT_FALSE(is_positive_definite({1, 0, 1, 0, 0, -1}));
  EXPECT_FALSE(is_positive_definite({1, 2, 1, 0, 0, 1}));
  EXPECT_FALSE(is_positive_definite({NAN, 0, 1, 0, 0, 1}));
  EXPECT_FALSE(is_positive_definite({INFINITY, 0, 1, 0, 0, 1}));
}

}  // namespace
}  // namespace skein::test
