// Recursive bisection by greedy growth and local search.
#include "partition/multilevel_bisect.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/hash.hpp"
#include "base/parallel.hpp"
#include "partition/multilevel_refine.hpp"

namespace skein {
namespace {

constexpr std::size_t kSmallest = 160;  ///< nodes of the coarsest graph
constexpr int kStarts = 8;              ///< places where a part starts to grow
constexpr int kPasses = 3;

struct Halves {
  std::array<std::int64_t, 2> target{}, capacity{};
};

std::int64_t total_weight(const Graph& g) { return std::accumulate(g.weight.begin(), g.weight.end(), std::int64_t{0}); }

/// What a cut costs: first the weight beyond the capacities, then the cut.
struct Cost {
  std::int64_t surplus = 0, cut = 0;
  friend auto operator<=>(const Cost&, const Cost&) = default;
};

/// Part 0 grows from a node, always by the one with the most contact, to its target; the rest is part 1.
void grow(const Graph& g, NodeId start, std::int64_t target, IdVector<NodeId, PartId>& part) {
  part.assign(g.nodes(), PartId{1});
  GainQueue queue(g.nodes());
  IdVector<NodeId, std::int64_t> gain(g.nodes(), 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    for (const Edge& e : g.edges(v)) gain[v] -= e.weight;
  }
  std::int64_t weight = 0;
  NodeId next = start;
  std::size_t tried = 0;  // nodes from `start` on, when the piece that it lies in has been taken
  while (weight < target) {
    if (next == kNoNode) {
      while (tried < g.nodes() && part[to_id<NodeId>((idx(start) + tried) % g.nodes())] == PartId{0}) ++tried;
      if (tried == g.nodes()) break;
      next = to_id<NodeId>((idx(start) + tried) % g.nodes());
    }
    // The last one only if that is nearer to the target.
    if (weight + g.weight[next] / 2 > target && weight > 0) break;
    part[next] = PartId{0};
    weight += g.weight[next];
    for (const Edge& e : g.edges(next)) {
      if (part[e.to] == PartId{0}) continue;
      if (queue.has(e.to)) queue.remove(e.to);
      gain[e.to] += 2 * e.weight;
      queue.push(e.to, gain[e.to]);
    }
    next = queue.pop().node;
  }
}

Cost refine(const Graph& g, const Halves& h, IdVector<NodeId, PartId>& part) {
  std::vector<std::int64_t> weight(2, 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) weight[idx(part[v])] += g.weight[v];
  Refiner refiner(g, part, weight, h.capacity);
  refiner.balance();
  const std::size_t patience = std::max<std::size_t>(30, g.nodes() / 40);
  for (int i = 0; i < kPasses && refiner.global_pass(patience) > 0; ++i) {
  }
  Cost c;
  for (std::size_t s = 0; s < 2; ++s) c.surplus += std::max<std::int64_t>(0, weight[s] - h.capacity[s]);
  c.cut = cut_rows(g, part);
  return c;
}

IdVector<NodeId, PartId> bisect(const Graph& g, const Halves& h, std::uint64_t seed) {
  const std::size_t n = g.nodes();
  IdVector<NodeId, PartId> part(n);
  if (n > kSmallest) {
    const auto limit = 3 * (total_weight(g) / static_cast<std::int64_t>(2 * kSmallest)) + 1;
    const Matching m = match_heavy_edges(g, limit, mix(seed ^ n) | 1);
    if (m.sets * 20 < n * 19) {
      const auto coarse = bisect(contract(g, m.node2set, m.sets, 0), h, seed);
      for (const NodeId v : IdRange<NodeId>(n)) part[v] = coarse[m.node2set[v]];
      refine(g, h, part);
      return part;
    }
  }
  Cost best;
  IdVector<NodeId, PartId> trial;
  for (int s = 0; s < kStarts; ++s) {
    const NodeId start = to_id<NodeId>(mix(seed + static_cast<std::uint64_t>(s)) % n);
    grow(g, start, h.target[0], trial);
    const Cost cost = refine(g, h, trial);
    if (s > 0 && best <= cost) continue;
    best = cost;
    part = trial;
  }
  return part;
}

class Recursion {
 public:
  Recursion(std::int64_t capacity, std::uint64_t seed, std::size_t nodes)
      : capacity_(capacity), seed_(seed), out_(nodes) {}

  /// The nodes of g, `nodes` in the whole graph, go to parts first .. first + parts - 1. Threads take a half each.
  void split(const Graph& g, const std::vector<NodeId>& nodes, int first, int parts, int threads) {
    if (parts == 1 || g.nodes() <= static_cast<std::size_t>(parts)) {
      for (std::size_t i = 0; i < nodes.size(); ++i)
        out_[nodes[i]] = PartId{first + (parts == 1 ? 0 : static_cast<int>(i))};
      return;
    }
    const std::array<int, 2> share{parts / 2, parts - parts / 2};
    const auto half = bisect(g, halves(g, share),
                             mix(seed_ ^ static_cast<std::uint64_t>(first) << 32) ^ static_cast<std::uint64_t>(parts));
    const auto go_on = [&](int s) {
      std::vector<NodeId> inside;
      const Graph sub = subgraph(g, half, PartId{s}, inside);
      for (NodeId& v : inside) v = nodes[idx(v)];
      split(sub, inside, s == 0 ? first : first + share[0], share[s], (threads + 1 - s) / 2);
    };
    const int at_once = threads > 1 ? 2 : 1;
    in_parallel(at_once, [&](int w) {
      for (int s = w; s < 2; s += at_once) go_on(s);
    });
  }
  IdVector<NodeId, PartId> take() { return std::move(out_); }

 private:
  /// What the parts may be heavier than their mean is shared out evenly over the bisections still to come.
  [[nodiscard]] Halves halves(const Graph& g, const std::array<int, 2>& share) const {
    const auto weight = static_cast<double>(total_weight(g));
    const double parts = share[0] + share[1];
    const double slack = std::max(1.0, static_cast<double>(capacity_) * parts / std::max(weight, 1.0));
    const double factor = std::pow(slack, 1 / std::ceil(std::log2(parts)));
    Halves h;
    for (std::size_t s = 0; s < 2; ++s) {
      const double target = weight * share[s] / parts;
      h.target[s] = static_cast<std::int64_t>(target);
      h.capacity[s] = static_cast<std::int64_t>(std::ceil(target * factor));
    }
    return h;
  }

  std::int64_t capacity_;
  std::uint64_t seed_;
  IdVector<NodeId, PartId> out_;
};

}  // namespace

IdVector<NodeId, PartId> bisect_recursively(const Graph& graph, int parts, std::int64_t capacity, std::uint64_t seed,
                                            int threads) {
  std::vector<NodeId> all(graph.nodes());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = to_id<NodeId>(i);
  Recursion r(capacity, seed, graph.nodes());
  r.split(graph, all, 0, parts, threads);
  return r.take();
}

}  // namespace skein
