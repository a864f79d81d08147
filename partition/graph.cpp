// The dual graph, matching and contraction.
#include "partition/graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "partition/interface_faces.hpp"
#include "partition/rendezvous.hpp"

namespace skein {
namespace {

/// All ranks' work adds up to about this: small enough that sums of it fit, fine enough for 10^10 tetrahedra.
constexpr double kTotalWeight = 1LL << 52;

}  // namespace

void set_weights(const Comm& comm, std::span<const double> work, Graph& g) {
  const double sum = comm.sum(std::accumulate(work.begin(), work.end(), 0.0));
  const auto tets = static_cast<double>(comm.sum(static_cast<std::int64_t>(work.size())));
  // A power of two, so that equal work stays equal and simple numbers stay simple.
  const double total = sum > 0 ? sum : std::max(tets, 1.0);
  const double scale = std::exp2(std::floor(std::log2(kTotalWeight / total)));
  g.weight.resize(work.size());
  for (const NodeId v : IdRange<NodeId>(work.size()))
    g.weight[v] = static_cast<std::int64_t>(std::llround((sum > 0 ? work[idx(v)] : 1.0) * scale));
}

Ghosts make_ghosts(const std::vector<std::pair<NodeId, RemoteNode>>& links) {
  Ghosts out;
  std::vector<std::pair<Rank, NodeId>> wanted;
  for (const auto& [mine, theirs] : links) {
    out.remote.push_back(theirs);
    wanted.emplace_back(theirs.rank, mine);
  }
  std::sort(out.remote.begin(), out.remote.end());
  out.remote.erase(std::unique(out.remote.begin(), out.remote.end()), out.remote.end());
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<Rank> dest;
  std::vector<NodeId> nodes;
  for (const auto& [rank, node] : wanted) {
    dest.push_back(rank);
    nodes.push_back(node);
  }
  out.wanted = pack(std::span<const Rank>(dest), std::span<const NodeId>(nodes));
  return out;
}

DistGraph dual_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                     std::span<const std::int32_t> face_weight) {
  const TetMesh& m = dist.mesh;
  const std::size_t n = m.tet_slots();
  const auto faces = match_interface(comm, dist);
  const auto weight_at = [&](FaceId f) { return face_weight.empty() ? 1 : std::max(1, face_weight[idx(f)]); };
  std::vector<std::int32_t> mine(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) mine[i] = weight_at(faces[i].mine);
  const auto theirs = swap_over_interface(comm, faces, mine);

  DistGraph out;
  std::vector<std::pair<NodeId, RemoteNode>> links(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    links[i] = {NodeId{num(face_tet(faces[i].mine))}, {faces[i].rank, NodeId{num(face_tet(faces[i].theirs))}}};
  }
  out.ghosts = make_ghosts(links);
  Graph& g = out.graph;
  set_weights(comm, work, g);
  g.first.reserve(n + 1);
  g.edge.reserve(4 * n);
  std::size_t i = 0;  // next interface face
  for (const TetId t : IdRange<TetId>(n)) {
    const auto add = [&](NodeId to, std::int32_t w) {  // two tetrahedra may share two faces
      for (std::size_t e = g.first.back(); e < g.edge.size(); ++e) {
        if (g.edge[e].to == to) return void(g.edge[e].weight += w);
      }
      g.edge.push_back({to, w});
    };
    for (int s = 0; s < 4; ++s) {
      const FaceId f = make_face(t, s), o = m.tet2face[t][static_cast<std::size_t>(s)];
      if (o != kNoFace) {
        add(NodeId{num(face_tet(o))}, std::max(weight_at(f), weight_at(o)));
      } else if (i < faces.size() && faces[i].mine == f) {
        const auto at = std::lower_bound(out.ghosts.remote.begin(), out.ghosts.remote.end(), links[i].second);
        add(to_id<NodeId>(n + static_cast<std::size_t>(at - out.ghosts.remote.begin())), std::max(mine[i], theirs[i]));
        ++i;
      }
    }
    g.first.push_back(static_cast<std::uint32_t>(g.edge.size()));
  }
  return out;
}

Matching match_heavy_edges(const Graph& g, std::int64_t max_weight, std::uint64_t seed) {
  const std::size_t n = g.nodes();
  IdVector<NodeId, NodeId> mate(n, kNoNode);
  std::vector<NodeId> order;
  if (seed != 0) {
    order.resize(n);
    for (std::size_t i = 0; i < n; ++i) {  // Fisher-Yates, inside out
      const std::size_t j = mix(seed + i) % (i + 1);
      order[i] = order[j];
      order[j] = to_id<NodeId>(i);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const NodeId v = seed == 0 ? to_id<NodeId>(i) : order[i];
    if (mate[v] != kNoNode) continue;
    mate[v] = v;
    double best = 0;
    for (const Edge& e : g.edges(v)) {
      if (idx(e.to) >= n || mate[e.to] != kNoNode || g.weight[v] + g.weight[e.to] > max_weight) continue;
      const double w = e.weight;
      const double rating = w * w / static_cast<double>(g.weight[e.to] + 1);  // the weight of v is the same for all
      if (rating <= best) continue;
      best = rating;
      mate[v] = e.to;
    }
    mate[mate[v]] = v;
  }
  Matching out;
  out.node2set.resize(n);
  for (const NodeId v : IdRange<NodeId>(n)) {
    out.node2set[v] = mate[v] < v ? out.node2set[mate[v]] : to_id<NodeId>(out.sets++);
  }
  return out;
}

Graph contract(const Graph& fine, const IdVector<NodeId, NodeId>& coarse, std::size_t nodes, std::size_t ghosts) {
  const std::size_t n = fine.nodes();
  // Members of each set, in rows.
  std::vector<std::uint32_t> member_first(nodes + 1, 0);
  for (const NodeId v : IdRange<NodeId>(n)) ++member_first[idx(coarse[v]) + 1];
  std::partial_sum(member_first.begin(), member_first.end(), member_first.begin());
  std::vector<NodeId> member(n);
  {
    std::vector<std::uint32_t> next(member_first.begin(), member_first.end() - 1);
    for (const NodeId v : IdRange<NodeId>(n)) member[next[idx(coarse[v])]++] = v;
  }
  Graph out;
  out.first.reserve(nodes + 1);
  out.edge.reserve(fine.edge.size() * 3 / 4);
  out.weight.assign(nodes, 0);
  IdVector<NodeId, std::uint32_t> place(nodes + ghosts, 0);  // of the edge to a node, plus 1, if in this row
  std::vector<Edge> row;
  for (std::size_t c = 0; c < nodes; ++c) {
    const auto begin = static_cast<std::uint32_t>(out.edge.size());
    std::size_t most = 0;
    for (std::uint32_t i = member_first[c]; i < member_first[c + 1]; ++i) most += fine.edges(member[i]).size();
    if (row.size() <= most) row.resize(2 * most + 1);
    std::uint32_t used = 0;
    std::int64_t weight = 0;
    for (std::uint32_t i = member_first[c]; i < member_first[c + 1]; ++i) {
      weight += fine.weight[member[i]];
      for (const Edge& e : fine.edges(member[i])) {
        const NodeId to = coarse[e.to];
        if (idx(to) == c) continue;
        const std::uint32_t at = place[to];  // whether it is new cannot be foreseen: no branch
        const bool is_new = at <= begin;
        Edge& sum = row[is_new ? used : at - begin - 1];
        sum = {to, (is_new ? 0 : sum.weight) + e.weight};
        used += is_new ? 1 : 0;
        place[to] = is_new ? begin + used : at;
      }
    }
    out.weight[to_id<NodeId>(c)] = weight;
    out.edge.insert(out.edge.end(), row.begin(), row.begin() + used);
    out.first.push_back(static_cast<std::uint32_t>(out.edge.size()));
  }
  return out;
}

Graph subgraph(const Graph& g, const IdVector<NodeId, Rank>& part, Rank which, std::vector<NodeId>& inside) {
  inside.clear();
  IdVector<NodeId, NodeId> number(g.nodes(), kNoNode);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    if (part[v] != which) continue;
    number[v] = to_id<NodeId>(inside.size());
    inside.push_back(v);
  }
  Graph out;
  out.weight.reserve(inside.size());
  out.first.reserve(inside.size() + 1);
  for (const NodeId v : inside) {
    out.weight.push_back(g.weight[v]);
    for (const Edge& e : g.edges(v)) {
      if (idx(e.to) < g.nodes() && number[e.to] != kNoNode) out.edge.push_back({number[e.to], e.weight});
    }
    out.first.push_back(static_cast<std::uint32_t>(out.edge.size()));
  }
  return out;
}

std::int64_t cut_rows(const Graph& g, const IdVector<NodeId, Rank>& part) {
  std::int64_t cut = 0;
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    for (const Edge& e : g.edges(v)) cut += part[e.to] != part[v] ? e.weight : 0;
  }
  return cut;
}

}  // namespace skein
