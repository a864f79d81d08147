// FeatureEdges against std::map.
#include "mesh/feature_edges.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace skein::test {
namespace {

using Model = std::map<std::pair<VertId, VertId>, std::pair<int, FeatureClass>>;

void expect_equal(const FeatureEdges& edges, const Model& model) {
  RC_ASSERT(edges.size() == model.size());
  for (const auto& [key, value] : model) {
    const FeatureEdge* e = edges.find(key.second, key.first);  // in either order
    RC_ASSERT(e != nullptr);
    RC_ASSERT(e->a == key.first && e->b == key.second && e->ref == value.first && e->edge_class == value.second);
    RC_ASSERT(e == edges.find(key.first, key.second));
  }
  for (const FeatureEdge& e : edges.list()) RC_ASSERT(e.a < e.b && model.count({e.a, e.b}) == 1);
}

RC_GTEST_PROP(FeatureEdges, ActsAsAMap, (std::uint32_t seed)) {
  std::mt19937 random(seed);
  const unsigned verts = *rc::gen::inRange(2u, 60u);
  const int steps = *rc::gen::inRange(0, 1500);
  FeatureEdges edges;
  Model model;
  for (int i = 0; i < steps; ++i) {
    // Ids far apart, and near ones that probe the same slots.
    const int stride = random() % 2 == 0 ? 1 : 65536;
    const VertId a{static_cast<int>(random() % verts) * stride}, b{static_cast<int>(random() % verts) * stride};
    if (a == b) continue;
    const auto key = std::minmax(a, b);
    if (random() % 5 < 3) {
      const int ref = static_cast<int>(random() % 7);
      const FeatureClass edge_class = random() % 2 == 0 ? kRidgeEdge : kThinEdge;
      edges.insert({a, b, ref, edge_class});
      model[key] = {ref, edge_class};
    } else {
      edges.erase(a, b);
      model.erase(key);
    }
    RC_ASSERT((edges.find(a, b) != nullptr) == (model.count(key) == 1));
    if (i % 50 == 0) expect_equal(edges, model);
  }
  expect_equal(edges, model);
}

TEST(FeatureEdges, AskingAndErasingInTheEmptySet) {
  FeatureEdges edges;
  EXPECT_EQ(edges.find(VertId{1}, VertId{2}), nullptr);
  edges.erase(VertId{1}, VertId{2});
  edges.insert({VertId{3}, VertId{1}, 5, kRidgeEdge});
  edges.clear();
  EXPECT_EQ(edges.size(), 0u);
  EXPECT_EQ(edges.find(VertId{1}, VertId{3}), nullptr);
  edges.insert({VertId{3}, VertId{1}, 6, FeatureClass{}});
  ASSERT_NE(edges.find(VertId{1}, VertId{3}), nullptr);
  EXPECT_EQ(edges.find(VertId{1}, VertId{3})->ref, 6);
}

}  // namespace
}  // namespace skein::test
