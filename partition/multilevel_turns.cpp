// Refinement over all ranks by turns.
#include "partition/multilevel_turns.hpp"

#include <algorithm>
#include <vector>

#include "base/hash.hpp"

namespace skein {

void refine_all(Refiner& r, std::size_t nodes) {
  r.balance();
  const std::size_t patience = std::max<std::size_t>(200, nodes / 200);
  for (int i = 0; i < 2 && r.global_pass(patience) > 0; ++i) {
  }
  for (int i = 0; i < 2 && r.local_pass(4, 25) > 0; ++i) {
  }
}

namespace {

using Parts = IdVector<NodeId, PartId>;

/// Which own nodes stay in this turn: those that touch a rank with the higher priority. So two nodes that touch
/// across ranks never move at the same time, and each gain is what it seems.
IdVector<NodeId, char> fixed_in_turn(const Comm& comm, const DistGraph& d, int turn) {
  const auto priority = [&](Rank r) {
    return mix(static_cast<std::uint64_t>(num(r)) * 64 + static_cast<std::uint64_t>(turn / 2));
  };
  const bool up = turn % 2 == 0;
  const std::uint64_t mine = priority(comm.rank());
  const Graph& g = d.graph;
  IdVector<NodeId, char> fixed(g.nodes(), 0);
  if (d.ghosts.remote.empty()) return fixed;
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    for (const Edge& e : g.edges(v)) {
      if (idx(e.to) < g.nodes()) continue;
      const std::uint64_t theirs = priority(d.ghosts.remote[idx(e.to) - g.nodes()].rank);
      if (up ? theirs > mine : theirs < mine) fixed[v] = 1;
    }
  }
  return fixed;
}

/// What one rank may do in a turn: each part's room, or surplus, shared out among the ranks that can reach it.
struct Shares {
  std::vector<std::int64_t> weight, capacity;
};
Shares share_room(const Comm& comm, const DistGraph& d, const Parts& part, int parts, std::int64_t capacity) {
  const Graph& g = d.graph;
  Shares s;
  s.weight.assign(static_cast<std::size_t>(parts), 0);
  std::vector<std::int64_t> here(s.weight.size(), 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) s.weight[idx(part[v])] += g.weight[v];
  for (const PartId p : part) here[idx(p)] = 1;
  comm.reduce(std::span<std::int64_t>(s.weight), Op::kSum);
  comm.reduce(std::span<std::int64_t>(here), Op::kSum);
  s.capacity.resize(s.weight.size());
  for (std::size_t p = 0; p < here.size(); ++p)
    s.capacity[p] = s.weight[p] + (capacity - s.weight[p]) / std::max<std::int64_t>(1, here[p]);
  return s;
}

}  // namespace

void refine_level(const Comm& comm, const DistGraph& d, int parts, std::int64_t capacity, Parts& part, Refine what,
                  int threads, NodeId stays) {
  const std::size_t n = d.graph.nodes();
  part.resize(n + d.ghosts.remote.size());
  const int turns = comm.size() == 1 ? 1 : 2;
  for (int turn = 0; turn < turns; ++turn) {
    const auto ghosts = d.ghosts.fetch(comm, [&](NodeId v) { return part[v]; });
    for (std::size_t i = 0; i < ghosts.size(); ++i) part[to_id<NodeId>(n + i)] = ghosts[i];
    auto fixed = fixed_in_turn(comm, d, turn);
    if (stays != kNoNode) fixed[stays] = 1;
    Shares s = share_room(comm, d, part, parts, capacity);
    Refiner refiner(d.graph, part, s.weight, s.capacity, &fixed, threads);
    if (what == Refine::kBalanceOnly) {
      refiner.balance();
    } else if (turn == 0) {
      refine_all(refiner, n);
    } else {
      refiner.balance();
      refiner.global_pass(std::max<std::size_t>(50, n / 500));
      refiner.local_pass(4, 25);
    }
  }
  part.resize(n);
}

}  // namespace skein
