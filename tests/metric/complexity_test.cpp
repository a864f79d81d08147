// The quadratures of sqrt(det M): what each is exact for, and what a unit mesh counts.
#include "metric/complexity.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numeric>

#include "tests/metric/tensors.hpp"

namespace skein::test {
namespace {

/// Two tetrahedra with a common face, and a free slot between them.
TetMesh two_tets() {
  TetMesh m;
  for (const Vec3 x : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{2, 2, 2}})
    m.coords.push_back(x);
  m.tet2vert.push_back({VertId{0}, VertId{1}, VertId{2}, VertId{3}});
  m.tet2vert.push_back({kNoVert, VertId{1}, VertId{2}, VertId{3}});
  m.tet2vert.push_back({VertId{1}, VertId{2}, VertId{3}, VertId{4}});
  return m;
}

TEST(Complexity, OfAUniformMetricIsVolumeTimesDensity) {
  const TetMesh m = two_tets();
  EXPECT_NEAR(complexity_of(m, [](VertId) { return 1000.0; }), 1000 * (1 + 5) / 6.0, 1e-10);
}

TEST(Complexity, VertexRuleIsExactForALinearDensity) {
  const TetMesh m = two_tets();
  const auto density = [](Vec3 x) { return 3 + 2 * x.x - x.y + 0.5 * x.z; };
  double exact = 0;
  for (const TetId t : {TetId{0}, TetId{2}}) {
    Vec3 sum;
    for (const VertId v : m.tet2vert[t]) sum += m.coords[v];
    exact += density(0.25 * sum) * volume6(m, t) / 6;
  }
  EXPECT_NEAR(complexity_of(m, [&](VertId v) { return density(m.coords[v]); }), exact, 1e-12);
}

TEST(Complexity, MeanOfALogLinearDensityIsExactWhereverItVaries) {
  for (const double k : {1e-3, 1.0, 1.9, 2.1, 10.0, 60.0}) {
    // 6 times the integral of exp(k x) (1-x)^2/2; as a series where k is small
    const double exact = k < 0.1 ? 1 + k / 4 + k * k / 20 : 3 * (2 * std::exp(k) - 2 - 2 * k - k * k) / (k * k * k);
    EXPECT_NEAR(mean_of_log_linear({0, k, 0, 0}), exact, 5e-3 * exact) << k;
    EXPECT_NEAR(mean_of_log_linear({3, 3, 3 + k, 3}), std::exp(3) * exact, 5e-3 * std::exp(3) * exact) << k;
  }
}

// A density that falls by six orders of magnitude from one end to the other: the mesh may be as coarse as it likes.
TEST(Complexity, OfALogLinearDensityIsTheSameOnAnyMesh) {
  const TetMesh m = two_tets();
  const auto l = [&](VertId v) { return 14 * m.coords[v].x - 7 * m.coords[v].y; };
  const auto density = [&](Vec3 x) { return std::exp(14 * x.x - 7 * x.y); };
  double sum = 0;  // the midpoint rule on many small prisms of parameter space
  constexpr int kSteps = 120;
  for (const TetId t : {TetId{0}, TetId{2}}) {
    const auto& v = m.tet2vert[t];
    const Vec3 o = m.coords[v[0]];
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        for (int k = 0; k < kSteps; ++k) {
          const double a = (i + 0.5) / kSteps, b = (j + 0.5) / kSteps * (1 - a), c = (k + 0.5) / kSteps * (1 - a - b);
          const double weight = (1 - a) * (1 - a - b) / (double(kSteps) * kSteps * kSteps);
          sum += weight * volume6(m, t) *
                 density(o + a * (m.coords[v[1]] - o) + b * (m.coords[v[2]] - o) + c * (m.coords[v[3]] - o));
        }
      }
    }
  }
  EXPECT_NEAR(complexity_of_log(m, l) / sum, 1, 0.01);
}

TEST(Complexity, WeightsGiveTheSameSum) {
  TetMesh m = two_tets();
  m.tet2vert.resize(1);  // no free slots
  const auto density = [&](VertId v) { return 1 + m.coords[v].x + 3 * m.coords[v].z; };
  const auto weight = vertex_rule_weights(m);
  double sum = 0;
  for (const VertId v : IdRange<VertId>(weight.size())) sum += weight[idx(v)] * density(v);
  EXPECT_NEAR(sum, complexity_of(m, density), 1e-14);
  EXPECT_EQ(weight[4], 0);
}

TEST(Complexity, RulesAgreeOnAConstantAndTheVertexFaceRuleIsTheBestOfAnExponential) {
  const AtVerts flat{1.5, 1.5, 1.5, 1.5};
  EXPECT_NEAR(vertex_face_rule(flat), std::exp(1.5), 1e-14);
  EXPECT_NEAR(centroid_rule(flat), std::exp(1.5), 1e-14);
  // The mean of exp(k x) over the tetrahedron 0, e1, e2, e3: 6 times the integral of exp(k x) (1-x)^2/2.
  const double k = 1;
  const double exact = 3 * (2 * std::exp(k) - 2 - 2 * k - k * k) / (k * k * k);
  const AtVerts l{0, k, 0, 0};
  const double vertices = vertex_rule({1, std::exp(k), 1, 1});
  EXPECT_NEAR(vertex_face_rule(l), exact, 1e-3 * exact);
  EXPECT_LT(centroid_rule(l), exact);
  EXPECT_GT(vertices, exact);
  EXPECT_LT(std::abs(vertex_face_rule(l) - exact), 0.1 * std::min(vertices - exact, exact - centroid_rule(l)));
}

RC_GTEST_PROP(Complexity, DensityOfALogarithmIsThatOfTheMetric, ()) {
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  const SymTensor m = random_metric(random, 0.1, 10);
  RC_ASSERT(std::abs(std::exp(log_sqrt_det(log(m))) / vert_metric(m).sqrt_det - 1) < 1e-9);
}

TEST(Complexity, TetrahedraOfAUnitMeshDoNotHangOnTheOrientation) {
  EXPECT_DOUBLE_EQ(tets_of_unit_mesh(100, 6), 1000);
  EXPECT_DOUBLE_EQ(tets_of_unit_mesh(100, -6), 1000);
}

}  // namespace
}  // namespace skein::test
