// Graph: weighted nodes and edges in rows, on one rank or over all ranks, and what it is coarsened to.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/ids.hpp"
#include "comm/exchange.hpp"

namespace skein {

enum class NodeId : std::int32_t {};  ///< node of a graph; from nodes() on: a ghost, a node of another rank
inline constexpr NodeId kNoNode{-1};

struct Edge {
  NodeId to = kNoNode;
  std::int32_t weight = 0;
};

/// Each edge between two own nodes is in the rows of both; a ghost has no row. No edge from a node to itself, no two
/// edges to the same node.
struct Graph {
  std::vector<std::uint32_t> first{0};  ///< row of node v: edge[first[v] .. first[v+1])
  std::vector<Edge> edge;
  IdVector<NodeId, std::int64_t> weight;  ///< work of each node

  [[nodiscard]] std::size_t nodes() const noexcept { return weight.size(); }
  [[nodiscard]] std::span<const Edge> edges(NodeId v) const noexcept {
    return {edge.data() + first[idx(v)], first[idx(v) + 1] - first[idx(v)]};
  }
};

/// A node of another rank.
struct RemoteNode {
  Rank rank{-1};
  NodeId node = kNoNode;
  friend auto operator<=>(const RemoteNode&, const RemoteNode&) = default;
};

/// The ghosts of a graph: ghost i is node NodeId(nodes() + i).
struct Ghosts {
  std::vector<RemoteNode> remote;  ///< ascending
  Packets<NodeId> wanted;          ///< which of the own nodes which ranks have as ghosts; each block ascending

  /// Collective. The other ranks' values at the ghosts, in their order. `of` gives the value of an own node.
  template <class Of>
  [[nodiscard]] auto fetch(const Comm& comm, Of&& of) const {
    Packets<decltype(of(NodeId{}))> send;
    send.rank = wanted.rank;
    send.offset = wanted.offset;
    send.items.reserve(wanted.items.size());
    for (const NodeId v : wanted.items) send.items.push_back(of(v));
    return exchange(comm, send).items;
  }
};

/// One rank's nodes of a graph over all ranks.
struct DistGraph {
  Graph graph;
  Ghosts ghosts;
};

/// Pairs of own node and the remote node behind it, as they come, to ghosts.
Ghosts make_ghosts(const std::vector<std::pair<NodeId, RemoteNode>>& links);

/// Collective. Node weights from one finite number >= 0 per node, scaled to integers by the same power of two on all
/// ranks.
void set_weights(const Comm& comm, std::span<const double> work, Graph& g);

/// The graph of nodes that are sets of another's nodes. `coarse` numbers the sets: one entry per own node and ghost,
/// own sets first (0 .. nodes-1), then sets of ghosts. Edges inside a set vanish, parallel ones add up. The same for
/// any number of threads.
Graph contract(const Graph& fine, const IdVector<NodeId, NodeId>& coarse, std::size_t nodes, std::size_t ghosts,
               int threads = 1);

/// Pairs of nodes with heavy edges and little weight (rating w^2 / (weight_u * weight_v)); no set heavier than
/// max_weight. Result: the set of each own node; sets are in the order of their first node. Nodes choose in
/// their order, or with a seed other than 0 in a random one. Each thread pairs the nodes of a share of its own; what is
/// left single at the borders of shares is paired afterwards.
struct Matching {
  IdVector<NodeId, NodeId> node2set;
  std::size_t sets = 0;
};
Matching match_heavy_edges(const Graph& graph, std::int64_t max_weight, std::uint64_t seed = 0, int threads = 1);

/// The own nodes with `part[v] == which` and the edges between them; `inside` gets their numbers.
Graph subgraph(const Graph& graph, const IdVector<NodeId, PartId>& part, PartId which, std::vector<NodeId>& inside);

/// Weight of the edges between different parts, those to ghosts included, each row counted (inner edges twice).
std::int64_t cut_rows(const Graph& graph, const IdVector<NodeId, PartId>& part);

}  // namespace skein
