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
