// The levels of the multilevel partition, inside a rank and over all ranks.
#include "partition/multilevel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/hash.hpp"
#include "base/parallel.hpp"
#include "partition/graph.hpp"
#include "partition/graph_pieces.hpp"
#include "partition/multilevel_bisect.hpp"
#include "partition/multilevel_refine.hpp"
#include "partition/multilevel_turns.hpp"

namespace skein {
namespace {

using Parts = IdVector<NodeId, PartId>;

/// Nodes of the graph that is cut by bisection, all ranks together.
std::size_t coarse_nodes(int parts) { return std::max<std::size_t>(5000, 30 * static_cast<std::size_t>(parts)); }

/// No coarse node may be heavier than this.
std::int64_t heaviest_node(std::int64_t total, int parts) {
  return 3 * (total / static_cast<std::int64_t>(2 * coarse_nodes(parts))) + 1;
}

/// What a cut costs: first the weight beyond the capacities, then the cut.
struct Cost {
  std::int64_t surplus = 0, cut = 0;
  friend auto operator<=>(const Cost&, const Cost&) = default;
};

struct Level {
  DistGraph dist;
  IdVector<NodeId, NodeId> node2coarse;  ///< of own nodes and ghosts; empty on the coarsest level
};

/// Improves the parts of a graph without ghosts.
Cost refine_cut(const Graph& g, int parts, std::int64_t capacity, Parts& part) {
  std::vector<std::int64_t> weight(static_cast<std::size_t>(parts), 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) weight[idx(part[v])] += g.weight[v];
  const std::vector<std::int64_t> capacities(weight.size(), capacity);
  Refiner refiner(g, part, weight, capacities);
  refine_all(refiner, g.nodes());
  Cost cost{0, cut_rows(g, part)};
  for (const auto w : weight) cost.surplus += std::max<std::int64_t>(0, w - capacity);
  return cost;
}

constexpr auto kAnyWeight = std::numeric_limits<std::int64_t>::max() / 2;

/// Gives loose pieces of parts to their neighbours, where that does not make the cut much longer. Only here, on few
/// nodes, can parts make room for them and still be improved.
void connect_coarse(const Graph& g, int parts, std::int64_t capacity, Cost cost, Parts& part) {
  const DistGraph whole{g, {}};
  const Comm alone = Comm::self();
  const auto count_loose = [&](Parts p) {
    return join_pieces(alone, whole, parts, 0, kAnyWeight, p);
  };  // no room at all
  const std::size_t loose = count_loose(part);
  if (loose == 0) return;
  Parts trial = part;
  join_pieces(alone, whole, parts, kAnyWeight, kAnyWeight, trial);
  const Cost then = refine_cut(g, parts, capacity, trial);
  if (count_loose(trial) >= loose) return;
  if (then.surplus <= cost.surplus && then.cut * 20 <= cost.cut * 21) part = std::move(trial);
}

/// The best of several cuts by bisection. With few parts they cost little, and luck in the first cuts counts more.
/// Threads take cuts of their own, or with one cut for many parts, halves of it; that changes nothing in what they
/// find.
Parts cut_coarse_graph(const Graph& g, int parts, std::int64_t capacity, std::uint64_t seed, int threads) {
  const std::size_t trials = parts < 16 ? 3 : 1;
  std::vector<Parts> trial(trials);
  std::vector<Cost> cost(trials);
  const int at_once = std::min(threads, static_cast<int>(trials));
  in_parallel(at_once, [&](int w) {
    for (auto i = static_cast<std::size_t>(w); i < trials; i += static_cast<std::size_t>(at_once)) {
      trial[i] = bisect_recursively(g, parts, capacity, mix(seed * trials + i), threads / at_once);
      cost[i] = refine_cut(g, parts, capacity, trial[i]);
    }
  });
  const auto best = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  connect_coarse(g, parts, capacity, cost[best], trial[best]);
  return std::move(trial[best]);
}

/// All levels of a graph without ghosts, and back.
Parts cut_graph(const Graph& g, int parts, std::int64_t total, std::int64_t capacity, std::uint64_t seed, int threads) {
  Parts part;
  Matching m;
  if (g.nodes() > coarse_nodes(parts)) m = match_heavy_edges(g, heaviest_node(total, parts));
  if (m.sets > 0 && m.sets * 20 < g.nodes() * 19) {
    const Parts coarse = cut_graph(contract(g, m.node2set, m.sets, 0), parts, total, capacity, seed, threads);
    part.resize(g.nodes());
    for (const NodeId v : IdRange<NodeId>(g.nodes())) part[v] = coarse[m.node2set[v]];
  } else {
    return cut_coarse_graph(g, parts, capacity, seed, threads);
  }
  refine_cut(g, parts, capacity, part);
  return part;
}

/// Collective. The next coarser level; false, and `fine` as it was, when no rank gets much smaller.
bool coarsen(const Comm& comm, Level& fine, std::size_t target, std::int64_t max_weight, int threads,
             DistGraph& coarse) {
  const Graph& g = fine.dist.graph;
  Matching m;
  if (g.nodes() > target) {
    m = match_heavy_edges(g, max_weight, 0, threads);
  } else {
    m.sets = g.nodes();
    m.node2set.resize(m.sets);
    for (const NodeId v : IdRange<NodeId>(m.sets)) m.node2set[v] = v;
  }
  const std::int32_t smaller = m.sets * 20 < g.nodes() * 19 ? 1 : 0;
  if (comm.max(smaller) == 0) return false;

  const auto sets = fine.dist.ghosts.fetch(comm, [&](NodeId v) { return m.node2set[v]; });
  const std::vector<RemoteNode>& remote = fine.dist.ghosts.remote;
  std::vector<RemoteNode> behind(remote.size());
  for (std::size_t i = 0; i < remote.size(); ++i) behind[i] = {remote[i].rank, sets[i]};
  std::vector<std::pair<NodeId, RemoteNode>> links;
  for (const NodeId v : IdRange<NodeId>(remote.empty() ? 0 : g.nodes())) {
    for (const Edge& e : g.edges(v)) {
      if (idx(e.to) >= g.nodes()) links.emplace_back(m.node2set[v], behind[idx(e.to) - g.nodes()]);
    }
  }
  coarse.ghosts = make_ghosts(links);
  const auto& ghosts = coarse.ghosts.remote;
  fine.node2coarse = std::move(m.node2set);
  for (const RemoteNode& r : behind) {
    const auto at = std::lower_bound(ghosts.begin(), ghosts.end(), r) - ghosts.begin();
    fine.node2coarse.push_back(to_id<NodeId>(m.sets + static_cast<std::size_t>(at)));
  }
  coarse.graph = contract(g, fine.node2coarse, m.sets, ghosts.size(), threads);
  return true;
}

/// Collective. All ranks' nodes as one graph, the same on every rank, by rank.
Graph gather_graph(const Comm& comm, const DistGraph& d, std::size_t& first) {
  const Graph& g = d.graph;
  const auto counts = comm.all_gather(static_cast<std::int64_t>(g.nodes()));
  std::vector<std::int64_t> start(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), start.begin() + 1);
  first = static_cast<std::size_t>(start[idx(comm.rank())]);
  std::vector<std::uint32_t> degree(g.nodes());
  std::vector<Edge> edge(g.edge);
  for (std::size_t v = 0; v < degree.size(); ++v) degree[v] = g.first[v + 1] - g.first[v];
  for (Edge& e : edge) {
    if (idx(e.to) < g.nodes()) {
      e.to = to_id<NodeId>(first + idx(e.to));
    } else {
      const RemoteNode& r = d.ghosts.remote[idx(e.to) - g.nodes()];
      e.to = to_id<NodeId>(static_cast<std::size_t>(start[idx(r.rank)]) + idx(r.node));
    }
  }
  Graph all;
  all.weight = IdVector<NodeId, std::int64_t>(comm.all_gather(g.weight.raw()));
  all.edge = comm.all_gather(edge);
  const auto degrees = comm.all_gather(degree);
  all.first.resize(degrees.size() + 1, 0);
  std::partial_sum(degrees.begin(), degrees.end(), all.first.begin() + 1);
  return all;
}

/// Collective. The parts of the coarsest level: every rank cuts the whole of it, the best cut wins.
Parts cut_coarsest(const Comm& comm, const DistGraph& d, int parts, std::int64_t total, std::int64_t capacity,
                   int threads) {
  std::size_t first = 0;
  const Graph all = gather_graph(comm, d, first);
  Parts part = cut_graph(all, parts, total, capacity, static_cast<std::uint64_t>(num(comm.rank())), threads);
  std::vector<std::int64_t> weight(static_cast<std::size_t>(parts), 0);
  for (const NodeId v : IdRange<NodeId>(all.nodes())) weight[idx(part[v])] += all.weight[v];
  Cost mine{0, cut_rows(all, part)};
  for (const auto w : weight) mine.surplus += std::max<std::int64_t>(0, w - capacity);
  const auto costs = comm.all_gather(mine);
  const auto winner = to_id<Rank>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  // The winner sends each rank its own nodes' parts.
  Packets<PartId> send;
  const auto ends = comm.all_gather(static_cast<std::int64_t>(first + d.graph.nodes()));
  if (comm.rank() == winner) {
    std::size_t begin = 0;
    for (std::size_t r = 0; r < ends.size(); ++r) {
      const auto end = static_cast<std::size_t>(ends[r]);
      if (end > begin) {
        send.rank.push_back(to_id<Rank>(r));
        send.offset.push_back(end);
      }
      begin = end;
    }
    send.items = part.raw();
  }
  return Parts(exchange(comm, send).items);
}

struct Capacity {
  std::int64_t search = 0;  ///< for the local search: leaves room for stray pieces
  std::int64_t end = 0;
};
/// A part may always have one tetrahedron more than the mean; more only if that is not the whole of a part.
Capacity capacities(std::int64_t total, std::int64_t heaviest, int parts, double imbalance) {
  const double mean = static_cast<double>(total) / parts;
  const double grain = std::min(static_cast<double>(heaviest), mean);
  const auto at = [&](double slack) {
    return static_cast<std::int64_t>(std::ceil(mean + std::max(slack * mean, grain)));
  };
  return {at(0.96 * imbalance), at(imbalance)};
}

/// Collective. The weight of all parts together beyond the capacity.
std::int64_t surplus(const Comm& comm, const Graph& g, int parts, std::int64_t capacity, const Parts& part) {
  std::vector<std::int64_t> weight(static_cast<std::size_t>(parts), 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) weight[idx(part[v])] += g.weight[v];
  comm.reduce(std::span<std::int64_t>(weight), Op::kSum);
  std::int64_t sum = 0;
  for (const auto w : weight) sum += std::max<std::int64_t>(0, w - capacity);
  return sum;
}

/// Collective. Makes the parts connected. Pieces that have only full neighbours go there nevertheless, and these pass
/// on what they have too much: small ones first, that costs next to no cut; then all, with a search for a shorter cut.
/// What that leaves loose is tried again from there; the best of all attempts is kept.
void connect_parts(const Comm& comm, const DistGraph& d, int parts, const Capacity& capacity, int threads,
                   Parts& part) {
  std::size_t left = join_pieces(comm, d, parts, capacity.end, kAnyWeight, part);
  const auto over = [&](const Parts& p) { return surplus(comm, d.graph, parts, capacity.end, p); };
  Parts trial = part;
  constexpr int kAttempts = 10;
  for (int i = 0; i < kAttempts && left > 0; ++i) {
    const bool small = i == 0;
    join_pieces(comm, d, parts, kAnyWeight, small ? capacity.end / 30 : kAnyWeight, trial);
    refine_level(comm, d, parts, capacity.search, trial, small ? Refine::kBalanceOnly : Refine::kAll, threads);
    const std::size_t then = join_pieces(comm, d, parts, capacity.end, kAnyWeight, trial);
    if (then >= left || over(trial) > over(part)) continue;
    left = then;
    part = trial;
  }
}

}  // namespace

IdVector<NodeId, PartId> multilevel_partition(const Comm& comm, DistGraph graph, int parts,
                                              const MultilevelOptions& options) {
  std::vector<Level> levels(1);
  levels[0].dist = std::move(graph);
  const Graph& g = levels[0].dist.graph;
  const auto n = static_cast<std::int64_t>(g.nodes());
  const std::int64_t total = comm.sum(std::accumulate(g.weight.begin(), g.weight.end(), std::int64_t{0}));
  const std::int64_t heaviest = comm.max(g.nodes() == 0 ? 0 : *std::max_element(g.weight.begin(), g.weight.end()));
  const Capacity capacity = capacities(total, heaviest, parts, options.imbalance);
  const auto all = static_cast<double>(std::max<std::int64_t>(1, comm.sum(n)));
  const auto target =
      static_cast<std::size_t>(static_cast<double>(coarse_nodes(parts)) * static_cast<double>(n) / all) + 1;

  for (DistGraph coarse; coarsen(comm, levels.back(), target, heaviest_node(total, parts), options.threads, coarse);) {
    levels.emplace_back();
    levels.back().dist = std::move(coarse);
    coarse = DistGraph{};
  }
  constexpr std::size_t kConnectAbove = 3;  // levels left; here it costs a tenth of what it does at the end
  Parts part = cut_coarsest(comm, levels.back().dist, parts, total, capacity.search, options.threads);
  while (levels.size() > 1) {
    levels.pop_back();
    const Level& fine = levels.back();
    Parts finer(fine.dist.graph.nodes());
    for (const NodeId v : IdRange<NodeId>(finer.size())) finer[v] = part[fine.node2coarse[v]];
    part = std::move(finer);
    refine_level(comm, fine.dist, parts, capacity.search, part, Refine::kAll, options.threads);
    if (levels.size() == kConnectAbove) connect_parts(comm, fine.dist, parts, capacity, options.threads, part);
  }
  connect_parts(comm, levels[0].dist, parts, capacity, options.threads, part);
  return part;
}

}  // namespace skein
