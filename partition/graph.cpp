// Weights, ghosts, matching and contraction.
#include "partition/graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/hash.hpp"
#include "base/parallel.hpp"
#include "partition/graph_rows.hpp"

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

namespace {

/// Nodes in pairs: `mate` is kNoNode for who has not been asked yet, the node itself for who has found nobody.
struct Pairing {
  const Graph& g;
  std::int64_t max_weight;
  IdVector<NodeId, NodeId>& mate;

  /// Gives v the best of the neighbours that may(neighbour).
  template <class May>
  void pair_up(NodeId v, const May& may) const {
    mate[v] = v;
    double best = 0;
    for (const Edge& e : g.edges(v)) {
      if (idx(e.to) >= g.nodes() || !may(e.to) || g.weight[v] + g.weight[e.to] > max_weight) continue;
      const double w = e.weight;
      const double rating = w * w / static_cast<double>(g.weight[e.to] + 1);  // the weight of v is the same for all
      if (rating <= best) continue;
      best = rating;
      mate[v] = e.to;
    }
    mate[mate[v]] = v;
  }
};

/// Numbers the sets by their first nodes.
Matching number_sets(const IdVector<NodeId, NodeId>& mate, int threads) {
  const std::size_t n = mate.size();
  Matching out;
  out.node2set.resize(n);
  std::vector<std::size_t> start(static_cast<std::size_t>(threads) + 1, 0);
  const auto share = [&](int w) { return IdRange<NodeId>(share_begin(n, w, threads), share_begin(n, w + 1, threads)); };
  in_parallel(threads, [&](int w) {
    std::size_t sets = 0;
    for (const NodeId v : share(w)) sets += mate[v] < v ? 0 : 1;
    start[static_cast<std::size_t>(w) + 1] = sets;
  });
  std::partial_sum(start.begin(), start.end(), start.begin());
  out.sets = start.back();
  in_parallel(threads, [&](int w) {
    std::size_t next = start[w];
    for (const NodeId v : share(w)) {
      if (mate[v] >= v) out.node2set[v] = to_id<NodeId>(next++);
    }
  });
  in_parallel(threads, [&](int w) {
    for (const NodeId v : share(w)) {
      if (mate[v] < v) out.node2set[v] = out.node2set[mate[v]];
    }
  });
  return out;
}

}  // namespace

Matching match_heavy_edges(const Graph& g, std::int64_t max_weight, std::uint64_t seed, int threads) {
  const std::size_t n = g.nodes();
  threads = seed == 0 ? threads_for(n, threads) : 1;
  IdVector<NodeId, NodeId> mate(n, kNoNode);
  const Pairing pairing{g, max_weight, mate};
  if (seed != 0) {
    std::vector<NodeId> order(n);
    for (std::size_t i = 0; i < n; ++i) {  // Fisher-Yates, inside out
      const std::size_t j = mix(seed + i) % (i + 1);
      order[i] = order[j];
      order[j] = to_id<NodeId>(i);
    }
    for (const NodeId v : order) {
      if (mate[v] == kNoNode) pairing.pair_up(v, [&](NodeId to) { return mate[to] == kNoNode; });
    }
    return number_sets(mate, 1);
  }
  in_parallel(threads, [&](int w) {
    const NodeId begin = to_id<NodeId>(share_begin(n, w, threads)), end = to_id<NodeId>(share_begin(n, w + 1, threads));
    for (const NodeId v : IdRange<NodeId>(idx(begin), idx(end))) {
      if (mate[v] != kNoNode) continue;
      pairing.pair_up(v, [&](NodeId to) { return to >= begin && to < end && mate[to] == kNoNode; });
    }
  });
  for (const NodeId v : IdRange<NodeId>(threads == 1 ? 0 : n)) {
    if (mate[v] == v) pairing.pair_up(v, [&](NodeId to) { return mate[to] == to; });
  }
  return number_sets(mate, threads);
}

Graph contract(const Graph& fine, const IdVector<NodeId, NodeId>& coarse, std::size_t nodes, std::size_t ghosts,
               int threads) {
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
  out.weight.resize(nodes);
  make_rows(out, nodes, fine.edge.size() * 3 / 4, threads_for(n, threads),
            [&](std::size_t begin, std::size_t end, std::vector<Edge>& edge, std::span<std::uint32_t> ends) {
              // Of the edge to a node, plus 1, if in this row.
              IdVector<NodeId, std::uint32_t> place(nodes + ghosts, 0);
              std::vector<Edge> row;
              for (std::size_t c = begin; c < end; ++c) {
                const auto row_begin = static_cast<std::uint32_t>(edge.size());
                std::size_t most = 0;
                for (std::uint32_t i = member_first[c]; i < member_first[c + 1]; ++i)
                  most += fine.edges(member[i]).size();
                if (row.size() <= most) row.resize(2 * most + 1);
                std::uint32_t used = 0;
                std::int64_t weight = 0;
                for (std::uint32_t i = member_first[c]; i < member_first[c + 1]; ++i) {
                  weight += fine.weight[member[i]];
                  for (const Edge& e : fine.edges(member[i])) {
                    const NodeId to = coarse[e.to];
                    if (idx(to) == c) continue;
                    const std::uint32_t at = place[to];  // whether it is new cannot be foreseen: no branch
                    const bool is_new = at <= row_begin;
                    Edge& sum = row[is_new ? used : at - row_begin - 1];
                    sum = {to, (is_new ? 0 : sum.weight) + e.weight};
                    used += is_new ? 1 : 0;
                    place[to] = is_new ? row_begin + used : at;
                  }
                }
                out.weight[to_id<NodeId>(c)] = weight;
                edge.insert(edge.end(), row.begin(), row.begin() + used);
                ends[c - begin] = static_cast<std::uint32_t>(edge.size());
              }
            });
  return out;
}

Graph subgraph(const Graph& g, const IdVector<NodeId, PartId>& part, PartId which, std::vector<NodeId>& inside) {
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

std::int64_t cut_rows(const Graph& g, const IdVector<NodeId, PartId>& part) {
  std::int64_t cut = 0;
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    for (const Edge& e : g.edges(v)) cut += part[e.to] != part[v] ? e.weight : 0;
  }
  return cut;
}

}  // namespace skein
