// A search from the interfaces inwards, then the rows of the graph.
#include "dist/border_graph.hpp"

#include <algorithm>
#include <utility>

#include "base/subset.hpp"

namespace skein {
namespace {

/// The tetrahedra of the shell, ascending.
std::vector<TetId> collect(const TetMesh& m, const std::vector<InterfaceFace>& faces, std::span<const double> work,
                           std::span<const double> reach) {
  if (std::all_of(reach.begin(), reach.end(), [](double r) { return r == kWholeRank; })) {
    std::vector<TetId> all(m.tet_slots());
    for (const TetId t : IdRange<TetId>(all.size())) all[idx(t)] = t;
    return all;
  }
  struct Found {
    TetId tet;
    Rank behind;  ///< the interface to this rank
  };
  std::vector<Found> found;
  IdVector<TetId, char> seen(m.tet_slots(), 0);
  std::vector<double> sum(reach.size(), 0);
  const auto take = [&](TetId t, Rank behind) {
    if (seen[t] != 0) return;
    seen[t] = 1;
    sum[idx(behind)] += work[idx(t)];
    found.push_back({t, behind});
  };
  for (const InterfaceFace& f : faces) take(face_tet(f.mine), f.rank);  // all of these: other ranks look at them
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto [t, behind] = found[i];
    if (sum[idx(behind)] >= reach[idx(behind)]) continue;
    for (const FaceId f : m.tet2face[t]) {
      if (f != kNoFace) take(face_tet(f), behind);
    }
  }
  Subset<TetId> tets(m.tet_slots());
  for (const Found& f : found) tets.insert(f.tet);
  tets.number();
  return tets.members();
}

/// Adds edges of one row; parallel ones become one. A row has a handful of edges.
void add_edge(Graph& g, NodeId to) {
  for (std::size_t e = g.first.back(); e < g.edge.size(); ++e) {
    if (g.edge[e].to == to) return void(++g.edge[e].weight);
  }
  g.edge.push_back({to, 1});
}
void close_row(Graph& g) { g.first.push_back(static_cast<std::uint32_t>(g.edge.size())); }

}  // namespace

BorderGraph border_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                         const std::vector<InterfaceFace>& faces, std::span<const double> reach) {
  const TetMesh& m = dist.mesh;
  BorderGraph out;
  out.tets = collect(m, faces, work, reach);
  out.core = out.tets.size() < m.tet_slots();
  const std::size_t n = out.tets.size(), nodes = n + (out.core ? 1 : 0);
  IdVector<TetId, NodeId> node(m.tet_slots(), to_id<NodeId>(n));
  for (std::size_t i = 0; i < n; ++i) node[out.tets[i]] = to_id<NodeId>(i);

  std::vector<NodeId> mine(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) mine[i] = node[face_tet(faces[i].mine)];
  const auto theirs = swap_over_interface(comm, faces, mine);
  std::vector<std::pair<NodeId, RemoteNode>> links(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) links[i] = {mine[i], {faces[i].rank, theirs[i]}};
  out.dist.ghosts = make_ghosts(links);
  const auto& remote = out.dist.ghosts.remote;

  Graph& g = out.dist.graph;
  std::vector<double> weight(nodes, 0);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) weight[idx(node[t])] += work[idx(t)];
  set_weights(comm, weight, g);
  std::vector<Edge> to_shell;  // of the core
  std::size_t i = 0;           // next interface face
  for (const TetId t : out.tets) {
    std::int32_t inwards = 0;
    for (std::size_t s = 0; s < 4; ++s) {
      const FaceId o = m.tet2face[t][s];
      if (o != kNoFace) {
        add_edge(g, node[face_tet(o)]);
        inwards += idx(node[face_tet(o)]) == n ? 1 : 0;
      } else if (i < faces.size() && faces[i].mine == make_face(t, s)) {
        const auto at = std::lower_bound(remote.begin(), remote.end(), links[i].second) - remote.begin();
        add_edge(g, to_id<NodeId>(nodes + static_cast<std::size_t>(at)));
        ++i;
      }
    }
    close_row(g);
    if (inwards > 0) to_shell.push_back({node[t], inwards});
  }
  if (out.core) {
    g.edge.insert(g.edge.end(), to_shell.begin(), to_shell.end());
    close_row(g);
  }
  return out;
}

}  // namespace skein
