// Order, orientation and repetition carry no meaning in a file: the mesh is the same.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// distribute() of `whole`; what it found, and the content of the mesh.
struct Result {
  DistributeReport report;
  Content content;
  double volume = 0;
};
Result result(const WholeMesh& whole) {
  const Comm& comm = world();
  Result r;
  const DistMesh dist = distribute(comm, slices(comm, whole), nullptr, {}, &r.report);
  reconcile(comm, dist);
  EXPECT_EQ(check(dist.mesh), "");
  r.content = content(comm, to_slices(comm, dist));
  r.volume = comm.sum(volume(dist.mesh));
  return r;
}

void expect_same_mesh(const Result& a, const Result& b) {
  EXPECT_EQ(a.content.verts, b.content.verts);
  EXPECT_EQ(a.content.tets, b.content.tets);
  EXPECT_EQ(a.content.tris, b.content.tris);
  EXPECT_EQ(a.content.edges, b.content.edges);
  EXPECT_EQ(a.content.required_tris, b.content.required_tris);
  EXPECT_NEAR(a.volume, b.volume, 1e-12);
}

TEST(Tidy, EntitiesMayBeTurned) {
  WholeMesh w = cube(4, Regions::kTwoTagged);
  const Result before = result(w);
  std::mt19937 random(7);
  std::int64_t odd = 0;
  for (auto& t : w.tets) {
    if (random() % 3 == 0) std::swap(t[random() % 2], t[2 + random() % 2]), ++odd;
  }
  for (auto& t : w.tris) std::shuffle(t.begin(), t.end(), random);
  const Result after = result(w);
  expect_same_mesh(before, after);
  EXPECT_EQ(after.report.turned_tets, odd);
}

TEST(Tidy, WhatIsGivenAgainIsDropped) {
  WholeMesh w = cube(4, Regions::kTwoTagged);
  w.edges = {{0, 1}, {1, 2}, {0, 5}};
  w.edge_ref = {3, 3, 4};
  w.required_tris = {4};
  const Result before = result(w);
  std::mt19937 random(8);
  const std::size_t tets = w.tets.size(), tris = w.tris.size();
  std::int64_t more_tets = 0, more_tris = 0;
  for (int times = 0; times < 2; ++times) {
    for (std::size_t t = 0; t < tets; ++t) {
      if (random() % 4 != 0) continue;
      auto v = w.tets[t];
      std::shuffle(v.begin(), v.end(), random);
      w.tets.push_back(v), w.tet_ref.push_back(w.tet_ref[t]), ++more_tets;
    }
    for (std::size_t t = 0; t < tris; ++t) {
      if (random() % 4 != 0) continue;
      auto v = w.tris[t];
      std::shuffle(v.begin(), v.end(), random);
      w.tris.push_back(v), w.tri_ref.push_back(w.tri_ref[t]), ++more_tris;
    }
  }
  w.edges.push_back({1, 0}), w.edge_ref.push_back(9);
  const Result after = result(w);
  expect_same_mesh(before, after);
  EXPECT_EQ(after.report.double_tets, more_tets);
  EXPECT_EQ(after.report.double_triangles, more_tris);
  EXPECT_EQ(after.report.double_edges, 1);
}

TEST(Tidy, WholeMeshGivenTwice) {
  WholeMesh w = cube(3);
  const Result before = result(w);
  const auto tets = w.tets;
  w.tets.insert(w.tets.end(), tets.begin(), tets.end());
  w.tet_ref.resize(w.tets.size(), 1);
  const Result after = result(w);
  expect_same_mesh(before, after);
  EXPECT_EQ(after.report.double_tets, std::ssize(tets));
}

}  // namespace
}  // namespace skein::test
