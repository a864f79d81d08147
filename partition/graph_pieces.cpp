// Pieces by joined sets inside the ranks; then the lowest number spreads over the ghosts.
#include "partition/graph_pieces.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "base/add_up.hpp"
#include "base/union_find.hpp"

namespace skein {
namespace {

using Parts = IdVector<NodeId, PartId>;

/// A connected piece of a part; as gathered, what one rank has of it.
struct Piece {
  std::int64_t label = 0;
  std::int64_t weight = 0;
  PartId part = kNoPart;
};
/// How much a piece touches another part.
struct Contact {
  std::int64_t label = 0;
  PartId part = kNoPart;
  std::int64_t weight = 0;
};

/// Collective. The same number at all nodes of a piece, another in every other piece. `part` has the ghosts' parts,
/// too.
IdVector<NodeId, std::int64_t> label_pieces(const Comm& comm, const DistGraph& d, const Parts& part) {
  const Graph& g = d.graph;
  const std::size_t n = g.nodes();
  UnionFind<NodeId> sets(n);
  std::vector<std::pair<NodeId, NodeId>> links;  // own node, ghost of the same part
  for (const NodeId v : IdRange<NodeId>(n)) {
    for (const Edge& e : g.edges(v)) {
      if (part[e.to] != part[v]) continue;
      if (idx(e.to) >= n) {
        links.emplace_back(v, e.to);
      } else if (e.to < v) {
        sets.join(v, e.to);
      }
    }
  }
  const auto first = comm.exclusive_sum(static_cast<std::int64_t>(n));
  IdVector<NodeId, std::int64_t> label(n);
  for (const NodeId v : IdRange<NodeId>(n)) label[v] = first + num(v);
  for (std::int32_t changed = 1; comm.max(changed) != 0;) {
    changed = 0;
    const auto theirs = d.ghosts.fetch(comm, [&](NodeId v) { return label[sets.root(v)]; });
    for (const auto& [v, ghost] : links) {
      std::int64_t& mine = label[sets.root(v)];
      if (theirs[idx(ghost) - n] >= mine) continue;
      mine = theirs[idx(ghost) - n];
      changed = 1;
    }
  }
  for (const NodeId v : IdRange<NodeId>(n)) label[v] = label[sets.root(v)];
  return label;
}

/// Collective. All pieces but the heaviest of each part, no heavier than max_piece; ascending by label.
std::vector<Piece> loose_pieces(const Comm& comm, const Graph& g, const Parts& part,
                                const IdVector<NodeId, std::int64_t>& label, std::int64_t max_piece) {
  std::vector<Piece> mine;
  const auto key = [](const Piece& p) { return p.label; };
  // Runs of equal labels along the nodes, so that the list stays short.
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    if (mine.empty() || mine.back().label != label[v]) mine.push_back({label[v], 0, part[v]});
    mine.back().weight += g.weight[v];
  }
  add_up(mine, key, &Piece::weight);
  std::vector<Piece> all = comm.all_gather(mine);
  add_up(all, key, &Piece::weight);
  std::sort(all.begin(), all.end(), [](const Piece& a, const Piece& b) {
    return std::tuple(a.part, -a.weight, a.label) < std::tuple(b.part, -b.weight, b.label);
  });
  std::vector<Piece> loose;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (all[i].part == all[i - 1].part && all[i].weight <= max_piece) loose.push_back(all[i]);
  }
  std::sort(loose.begin(), loose.end(), [&](const Piece& a, const Piece& b) { return a.label < b.label; });
  return loose;
}

const Piece* find_piece(const std::vector<Piece>& pieces, std::int64_t label) {
  const auto it =
      std::lower_bound(pieces.begin(), pieces.end(), label, [](const Piece& p, std::int64_t l) { return p.label < l; });
  return it != pieces.end() && it->label == label ? &*it : nullptr;
}

/// Collective. What the loose pieces touch, by label and then contact, most first.
std::vector<Contact> find_contacts(const Comm& comm, const Graph& g, const Parts& part,
                                   const IdVector<NodeId, std::int64_t>& label, const std::vector<Piece>& loose) {
  std::vector<Contact> mine;
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    if (find_piece(loose, label[v]) == nullptr) continue;
    for (const Edge& e : g.edges(v)) {
      if (part[e.to] != part[v]) mine.push_back({label[v], part[e.to], e.weight});
    }
  }
  const auto key = [](const Contact& c) { return std::pair(c.label, c.part); };
  add_up(mine, key, &Contact::weight);
  std::vector<Contact> all = comm.all_gather(mine);
  add_up(all, key, &Contact::weight);
  std::sort(all.begin(), all.end(), [](const Contact& a, const Contact& b) {
    return std::tuple(a.label, -a.weight, a.part) < std::tuple(b.label, -b.weight, b.part);
  });
  return all;
}

/// Of loose pieces, how many have got a new part, and how many would if there was room.
struct Placed {
  std::size_t moved = 0, left = 0;
};
/// Collective. Gives the loose pieces new parts, the lightest first, as long as there is room.
Placed place_pieces(const Comm& comm, const DistGraph& d, int parts, std::int64_t capacity, std::vector<Piece>& loose,
                    const IdVector<NodeId, std::int64_t>& label, Parts& part) {
  const Graph& g = d.graph;
  const auto contacts = find_contacts(comm, g, part, label, loose);
  std::vector<std::int64_t> weight(static_cast<std::size_t>(parts), 0);
  for (const NodeId v : IdRange<NodeId>(g.nodes())) weight[idx(part[v])] += g.weight[v];
  comm.reduce(std::span<std::int64_t>(weight), Op::kSum);

  std::vector<std::size_t> order(loose.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return loose[a].weight < loose[b].weight; });
  Placed placed;
  for (const std::size_t i : order) {
    Piece& p = loose[i];
    const auto touched = std::lower_bound(contacts.begin(), contacts.end(), p.label,
                                          [](const Contact& x, std::int64_t l) { return x.label < l; });
    const auto is_of = [&](auto c) { return c != contacts.end() && c->label == p.label; };
    if (!is_of(touched)) continue;  // a body of its own
    auto c = touched;
    while (is_of(c) && weight[idx(c->part)] + p.weight > capacity) ++c;
    if (!is_of(c)) {
      ++placed.left;
      continue;
    }
    weight[idx(p.part)] -= p.weight;
    weight[idx(c->part)] += p.weight;
    p.part = c->part;
    ++placed.moved;
  }
  for (const NodeId v : IdRange<NodeId>(g.nodes())) {
    if (const Piece* p = find_piece(loose, label[v])) part[v] = p->part;
  }
  return placed;
}

}  // namespace

std::size_t join_pieces(const Comm& comm, const DistGraph& d, int parts, std::int64_t capacity, std::int64_t max_piece,
                        Parts& part) {
  const std::size_t n = d.graph.nodes();
  std::size_t left = 0;
  constexpr int kRounds = 4;  // a piece may have gone to another loose piece
  for (int r = 0; r < kRounds; ++r) {
    part.resize(n);
    for (const PartId p : d.ghosts.fetch(comm, [&](NodeId v) { return part[v]; })) part.push_back(p);
    const auto label = label_pieces(comm, d, part);
    auto loose = loose_pieces(comm, d.graph, part, label, max_piece);
    const Placed placed = loose.empty() ? Placed{} : place_pieces(comm, d, parts, capacity, loose, label, part);
    left = placed.left;
    if (placed.moved == 0) break;
  }
  part.resize(n);
  return left;
}

}  // namespace skein
