// Graph: weighted nodes and edges, stored in rows, on one rank or over all ranks; and coarsening.
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

/// Ghosts from pairs of an own node and the remote node at the other end of its edge, in any order.
Ghosts make_ghosts(const std::vector<std::pair<NodeId, RemoteNode>>& links);

/// Collective. Node weights from one finite number >= 0 per node, scaled to integers by the same power of two on all
/// ranks.
void set_weights(const Comm& comm, std::span<const double> work, Graph& g);

/// The coarse graph whose nodes are sets of nodes of this graph. `coarse` is the set of each own node and ghost; sets
/// of own nodes come first (0 .. nodes-1), then sets of ghosts. Edges inside a set vanish; weights of parallel edges
/// are added. The same for any number of threads.
Graph contract(const Graph& fine, const IdVector<NodeId, NodeId>& coarse, std::size_t nodes, std::size_t ghosts,
               int threads = 1);

/// A matching: pairs of nodes with a heavy edge and little weight (largest w^2 / (weight_u * weight_v)); no pair
/// heavier than max_weight. Result: the set (a pair or a single node) of each own node; sets are in the order of their
/// first node. Nodes choose their mates in their order, or in a random order if seed is not 0. Each thread pairs a
/// share of the nodes; nodes that stay single at the borders of the shares are paired afterwards.
struct Matching {
  IdVector<NodeId, NodeId> node2set;
  std::size_t sets = 0;
};
Matching match_heavy_edges(const Graph& graph, std::int64_t max_weight, std::uint64_t seed = 0, int threads = 1);

/// The subgraph of the own nodes with `part[v] == which`; their numbers in this graph go to `inside`.
Graph subgraph(const Graph& graph, const IdVector<NodeId, PartId>& part, PartId which, std::vector<NodeId>& inside);

/// Weight of the edges between different parts, edges to ghosts included. All rows are added up, so an edge between two
/// own nodes counts twice.
std::int64_t cut_rows(const Graph& graph, const IdVector<NodeId, PartId>& part);

}  // namespace skein
