// Diffusion of work over the graph of the parts.
#include "dist/rebalance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/add_up.hpp"
#include "dist/border_graph.hpp"
#include "partition/graph.hpp"
#include "partition/graph_pieces.hpp"
#include "partition/multilevel_refine.hpp"
#include "partition/multilevel_turns.hpp"

namespace skein {
namespace {

using Parts = IdVector<NodeId, PartId>;

/// Two parts that touch: how many faces, as seen from `from`; what shall flow.
struct Flow {
  PartId from = kNoPart, to = kNoPart;
  double contact = 0;
  double work = 0;
};
std::pair<PartId, PartId> pair_of(const Flow& f) noexcept { return {f.from, f.to}; }
bool before(const Flow& a, const Flow& b) noexcept { return pair_of(a) < pair_of(b); }

/// The pairs of parts that touch at this rank's nodes; ascending. `part` has the ghosts' parts, too.
std::vector<Flow> local_contacts(const Graph& g, const Parts& part) {
  std::vector<Flow> out;
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    for (const Edge& e : g.edges(v)) {
      if (part[e.to] != part[v]) out.push_back({part[v], part[e.to], 1, 0});
    }
  }
  add_up(out, pair_of, &Flow::contact);
  return out;
}

/// The potentials x with L x = b by conjugate gradients, L the Laplacian of the parts with the contacts as
/// weights. Wide interfaces so take more of the flow.
std::vector<double> solve(const std::vector<Flow>& edges, const std::vector<double>& b) {
  const std::size_t n = b.size();
  const auto apply = [&](const std::vector<double>& x) {
    std::vector<double> y(n, 0);
    for (const Flow& e : edges) y[idx(e.from)] += e.contact * (x[idx(e.from)] - x[idx(e.to)]);
    return y;
  };
  const auto dot = [](const std::vector<double>& p, const std::vector<double>& q) {
    return std::inner_product(p.begin(), p.end(), q.begin(), 0.0);
  };
  std::vector<double> x(n, 0), r(b), d(b);
  double rr = dot(r, r);
  const double enough = 1e-10 * rr;
  for (std::size_t i = 0; i < 4 * n && rr > enough; ++i) {
    const auto ad = apply(d);
    const double curve = dot(d, ad);
    if (curve <= 0) break;
    const double alpha = rr / curve, old = rr;
    for (std::size_t k = 0; k < n; ++k) {
      x[k] += alpha * d[k];
      r[k] -= alpha * ad[k];
    }
    rr = dot(r, r);
    for (std::size_t k = 0; k < n; ++k) d[k] = r[k] + rr / old * d[k];
  }
  return x;
}

/// weight - mean of the parts that can be reached from each other.
template <class Weight>
std::vector<double> surplus(const std::vector<Flow>& edges, const std::vector<Weight>& weight) {
  std::vector<std::size_t> piece(weight.size());
  std::iota(piece.begin(), piece.end(), std::size_t{0});
  for (bool changed = true; changed;) {
    changed = false;
    for (const Flow& e : edges) {
      if (piece[idx(e.to)] >= piece[idx(e.from)]) continue;
      piece[idx(e.from)] = piece[idx(e.to)];
      changed = true;
    }
  }
  std::vector<double> sum(weight.size(), 0), count(weight.size(), 0), out(weight.size());
  for (std::size_t p = 0; p < weight.size(); ++p) {
    sum[piece[p]] += static_cast<double>(weight[p]);
    count[piece[p]] += 1;
  }
  for (std::size_t p = 0; p < weight.size(); ++p)
    out[p] = static_cast<double>(weight[p]) - sum[piece[p]] / count[piece[p]];
  return out;
}

/// Collective. What this rank's nodes shall take from part to part: of each flow the share of its contact. Ascending.
std::vector<Flow> plan_flows(const Comm& comm, const Graph& g, const Parts& part,
                             const std::vector<std::int64_t>& weight) {
  std::vector<Flow> mine = local_contacts(g, part);
  std::vector<Flow> all = comm.all_gather(mine);
  add_up(all, pair_of, &Flow::contact);
  const auto potential = solve(all, surplus(all, weight));
  for (Flow& f : mine) {
    const double drop = potential[idx(f.from)] - potential[idx(f.to)];
    f.work = std::max(0.0, drop * f.contact);  // the whole flow is drop * whole contact
  }
  return mine;
}

/// Takes nodes from part to part until the flows are used up.
class Transfer {
 public:
  /// `core` stays where it is; kNoNode: there is none.
  Transfer(const Graph& g, NodeId core, Parts& part, std::vector<Flow>& flows)
      : g_(g), part_(part), flows_(flows), queue_(g.nodes(), GainQueue::Order::kFirstFirst), moved_(g.nodes(), 0) {
    if (core != kNoNode) moved_[core] = 1;
  }

  void run() {
    for (const NodeId v : IdRange<NodeId>(g_.nodes())) {
      if (moved_[v] == 0) enqueue(v);
    }
    for (;;) {
      const auto [v, expected] = queue_.pop();
      if (v == kNoNode) break;
      const Choice c = choose(v);
      if (c.flow == nullptr) continue;
      if (GainQueue::clamp(c.gain) < expected) {
        queue_.push(v, c.gain);
        continue;
      }
      c.flow->work -= static_cast<double>(g_.weight[v]);
      part_[v] = c.flow->to;
      moved_[v] = 1;
      for (const Edge& e : g_.edges(v)) {
        if (idx(e.to) >= g_.nodes() || moved_[e.to] != 0) continue;
        if (queue_.has(e.to)) queue_.remove(e.to);
        enqueue(e.to);
      }
    }
  }

 private:
  struct Choice {
    Flow* flow = nullptr;
    std::int64_t gain = 0;
  };
  /// The flow that v would shorten the interface most with.
  Choice choose(NodeId v) {
    Choice best;
    std::int64_t inner = 0;
    for (const Edge& e : g_.edges(v)) inner += part_[e.to] == part_[v] ? e.weight : 0;
    for (const Edge& e : g_.edges(v)) {
      if (part_[e.to] == part_[v]) continue;
      Flow* f = find(part_[v], part_[e.to]);
      // The last one only if that comes nearer to the wanted sum.
      if (f == nullptr || f->work <= 0 || static_cast<double>(g_.weight[v]) > 2 * f->work) continue;
      std::int64_t contact = 0;
      for (const Edge& o : g_.edges(v)) contact += part_[o.to] == part_[e.to] ? o.weight : 0;
      if (best.flow == nullptr || contact - inner > best.gain) best = {f, contact - inner};
    }
    return best;
  }
  Flow* find(PartId from, PartId to) {
    const auto it = std::lower_bound(flows_.begin(), flows_.end(), Flow{from, to, 0, 0}, before);
    return it != flows_.end() && it->from == from && it->to == to ? &*it : nullptr;
  }
  void enqueue(NodeId v) {
    const Choice c = choose(v);
    if (c.flow != nullptr) queue_.push(v, c.gain);
  }

  const Graph& g_;
  Parts& part_;
  std::vector<Flow>& flows_;
  GainQueue queue_;
  IdVector<NodeId, char> moved_;  ///< or must stay
};

/// Collective. A first node for each rank that has none, from the rank with the most work for each that it has to feed.
void seed_empty(const Comm& comm, const Graph& g, const std::vector<std::int64_t>& weight, Parts& part) {
  const auto nodes = comm.all_gather(static_cast<std::int64_t>(g.nodes()));
  std::vector<std::int64_t> fed(nodes.size(), 0);
  std::vector<PartId> mine;  // whom this rank feeds
  for (std::size_t p = 0; p < nodes.size(); ++p) {
    if (nodes[p] > 0) continue;
    std::size_t donor = nodes.size();
    for (std::size_t d = 0; d < nodes.size(); ++d) {
      if (nodes[d] <= fed[d] + 1) continue;  // has to keep one
      if (donor == nodes.size() || weight[d] / (fed[d] + 1) > weight[donor] / (fed[donor] + 1)) donor = d;
    }
    if (donor == nodes.size()) return;  // fewer tetrahedra than ranks
    ++fed[donor];
    if (idx(comm.rank()) == donor) mine.push_back(to_id<PartId>(p));
  }
  for (std::size_t i = 0; i < mine.size(); ++i) part[to_id<NodeId>(g.nodes() * i / mine.size())] = mine[i];
}

/// Collective. The work of each part.
std::vector<std::int64_t> weigh(const Comm& comm, const Graph& g, const Parts& part) {
  std::vector<std::int64_t> weight(static_cast<std::size_t>(comm.size()), 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) weight[idx(part[v])] += g.weight[v];
  comm.reduce(std::span<std::int64_t>(weight), Op::kSum);
  return weight;
}

/// Collective. Moves nodes until no part is beyond its capacity; tells whether that is so. The core of a shell is much
/// heavier than any flow and stays; to look for a place for it whenever one of its thousands of neighbours moves would
/// be most of the work.
bool diffuse(const Comm& comm, const BorderGraph& shell, double imbalance, Parts& part) {
  const DistGraph& d = shell.dist;
  const Graph& g = d.graph;
  const std::size_t n = g.nodes();
  part.assign(n, part_of(comm.rank()));
  auto weight = weigh(comm, g, part);
  const double mean = static_cast<double>(std::accumulate(weight.begin(), weight.end(), std::int64_t{0})) / comm.size();
  const auto tets = static_cast<std::ptrdiff_t>(shell.tets.size());
  const std::int64_t heaviest = comm.max(tets == 0 ? 0 : *std::max_element(g.weight.begin(), g.weight.begin() + tets));
  const auto capacity =
      static_cast<std::int64_t>(std::ceil(mean + std::max(imbalance * mean, static_cast<double>(heaviest))));
  const auto balanced = [&] { return *std::max_element(weight.begin(), weight.end()) <= capacity; };
  if (balanced()) return true;

  const NodeId core = shell.core ? to_id<NodeId>(n - 1) : kNoNode;
  seed_empty(comm, g, weight, part);
  constexpr int kRounds = 12;  // each moves work by one part
  for (int r = 0; r < kRounds && !balanced(); ++r) {
    part.resize(n);
    for (const PartId p : d.ghosts.fetch(comm, [&](NodeId v) { return part[v]; })) part.push_back(p);
    weight = weigh(comm, g, part);
    std::vector<Flow> flows = plan_flows(comm, g, part, weight);
    Transfer(g, core, part, flows).run();
    weight = weigh(comm, g, part);
  }
  part.resize(n);
  refine_level(comm, d, comm.size(), capacity, part, Refine::kAll, 1, core);  // the new interfaces are rough
  // What was in pieces before is left alone: it would be much to move.
  constexpr double kStray = 0.01;
  join_pieces(comm, d, comm.size(), capacity, static_cast<std::int64_t>(kStray * mean), part);
  if (core != kNoNode) part[core] = part_of(comm.rank());
  weight = weigh(comm, g, part);
  return balanced();
}

/// Collective. How much work behind the faces to each rank may have to leave: what flows there in the first round, more
/// for what the others correct, and a little where nothing flows.
std::vector<double> find_reach(const Comm& comm, const std::vector<InterfaceFace>& faces, double mine) {
  constexpr double kMore = 2, kLeast = 0.02;
  std::vector<Flow> contacts;
  for (const InterfaceFace& f : faces) contacts.push_back({part_of(comm.rank()), part_of(f.rank), 1, 0});
  add_up(contacts, pair_of, &Flow::contact);
  const auto all = comm.all_gather(contacts);  // ascending, as each rank's are
  const auto potential = solve(all, surplus(all, comm.all_gather(mine)));
  std::vector<double> reach(static_cast<std::size_t>(comm.size()), 0);
  for (const Flow& f : contacts) {
    const double flow = f.contact * (potential[idx(f.from)] - potential[idx(f.to)]);
    const double share = f.contact / static_cast<double>(faces.size());
    reach[idx(f.to)] = kMore * std::max(0.0, flow) + kLeast * share * mine;
  }
  return reach;
}

}  // namespace

IdVector<TetId, Rank> rebalance(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                                double imbalance) {
  const double mine = std::accumulate(work.begin(), work.end(), 0.0);
  // A rank without tetrahedra is no neighbour of any; a few tetrahedra are no shell.
  const bool bits = comm.min(static_cast<std::int64_t>(work.size())) < 1000;
  const auto faces = match_interface(comm, dist);
  const std::vector<double> whole(static_cast<std::size_t>(comm.size()), kWholeRank);
  IdVector<TetId, Rank> dest(work.size(), comm.rank());
  Parts part;
  BorderGraph shell = border_graph(comm, dist, work, faces, bits ? whole : find_reach(comm, faces, mine));
  if (!diffuse(comm, shell, imbalance, part) && comm.max(std::int32_t{shell.core}) != 0) {
    shell = border_graph(comm, dist, work, faces, whole);
    diffuse(comm, shell, imbalance, part);
  }
  for (std::size_t i = 0; i < shell.tets.size(); ++i) dest[shell.tets[i]] = rank_of(part[to_id<NodeId>(i)]);
  return dest;
}

}  // namespace skein
