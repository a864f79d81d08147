// The dual graph near the interfaces: a piece of the whole one, with everything else as one node.
#include "dist/border_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "dist/dual_graph.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

std::int64_t total(const Comm& comm, const Graph& g) {
  return comm.sum(std::accumulate(g.weight.begin(), g.weight.end(), std::int64_t{0}));
}

BorderGraph shell_around(const Comm& comm, const DistMesh& dist, std::span<const double> work, double reach) {
  return border_graph(comm, dist, work, match_interface(comm, dist),
                      std::vector<double>(static_cast<std::size_t>(comm.size()), reach));
}

TEST(BorderGraph, HasAllWeightAndTheRowsOfTheWhole) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(8)));
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  const DistGraph whole = dual_graph(comm, dist, work);
  const BorderGraph shell = shell_around(comm, dist, work, 0.2 * static_cast<double>(work.size()));
  if (comm.size() == 1) return;  // no interface, no shell
  EXPECT_TRUE(shell.core);
  const Graph& g = shell.dist.graph;
  ASSERT_EQ(g.nodes(), shell.tets.size() + 1);
  EXPECT_EQ(total(comm, g), total(comm, whole.graph));
  EXPECT_EQ(shell.dist.ghosts.remote.size(), whole.ghosts.remote.size());  // all of the interface is in it
  std::int64_t into_core = 0;
  for (std::size_t i = 0; i < shell.tets.size(); ++i) {
    const NodeId node = to_id<NodeId>(i), tet = NodeId{num(shell.tets[i])};
    std::int64_t weight = 0, expected = 0;
    for (const Edge& e : g.edges(node)) {
      weight += e.weight;
      into_core += idx(e.to) == shell.tets.size() ? e.weight : 0;
    }
    for (const Edge& e : whole.graph.edges(tet)) expected += e.weight;
    EXPECT_EQ(weight, expected);
  }
  std::int64_t from_core = 0;
  for (const Edge& e : g.edges(to_id<NodeId>(shell.tets.size()))) from_core += e.weight;
  EXPECT_EQ(from_core, into_core);
}

TEST(BorderGraph, ReachesBehindThoseInterfacesOnlyThatAreNamed) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(8)));
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  const auto faces = match_interface(comm, dist);
  std::vector<double> reach(static_cast<std::size_t>(comm.size()), 0);
  IdVector<TetId, char> there(work.size(), 0);
  for (const InterfaceFace& f : faces) there[face_tet(f.mine)] = 1;
  const auto on_interface = static_cast<std::size_t>(std::count(there.begin(), there.end(), 1));
  EXPECT_EQ(border_graph(comm, dist, work, faces, reach).tets.size(), on_interface);
  if (faces.empty()) return;
  const Rank behind = faces.front().rank;
  const auto at_it =
      std::count_if(faces.begin(), faces.end(), [&](const InterfaceFace& f) { return f.rank == behind; });
  reach[idx(behind)] = 2.0 * static_cast<double>(at_it);  // each has a tetrahedron or shares it with others
  const auto reached = border_graph(comm, dist, work, faces, reach).tets.size();
  EXPECT_GT(reached, on_interface);
  EXPECT_LE(reached, on_interface + 2 * static_cast<std::size_t>(at_it) + 3);
}

TEST(BorderGraph, IsTheWholeGraphWhereItReachesThatFar) {
  const Comm& comm = world();
  const DistMesh dist = distribute(comm, slices(comm, cube(4)));
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  const BorderGraph shell = shell_around(comm, dist, work, kWholeRank);
  const DistGraph whole = dual_graph(comm, dist, work);
  EXPECT_FALSE(shell.core);
  EXPECT_EQ(shell.dist.graph.weight, whole.graph.weight);
  EXPECT_EQ(shell.dist.graph.first, whole.graph.first);
}

}  // namespace
}  // namespace skein::test
