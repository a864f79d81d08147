// Local search between parts.
#include "partition/multilevel_refine.hpp"

#include <algorithm>

namespace skein {

GainQueue::GainQueue(std::size_t nodes, Order order)
    : next_(nodes), prev_(nodes), at_(nodes, -1), head_(2 * kReach + 1, kNoNode), order_(order) {
  if (order == Order::kFirstFirst) tail_.assign(head_.size(), kNoNode);
}

std::int32_t GainQueue::clamp(std::int64_t gain) noexcept {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(gain, -kReach, kReach));
}

void GainQueue::push(NodeId v, std::int64_t gain) noexcept {
  const std::int32_t list = clamp(gain) + kReach;
  const auto l = static_cast<std::size_t>(list);
  at_[v] = list;
  top_ = std::max(top_, list);
  ++size_;
  NodeId& head = head_[l];
  if (order_ == Order::kLastFirst || head == kNoNode) {
    next_[v] = head;
    prev_[v] = kNoNode;
    if (head != kNoNode) prev_[head] = v;
    head = v;
    if (order_ == Order::kFirstFirst) tail_[l] = v;
  } else {
    next_[v] = kNoNode;
    prev_[v] = tail_[l];
    next_[tail_[l]] = v;
    tail_[l] = v;
  }
}

void GainQueue::remove(NodeId v) noexcept {
  const auto l = static_cast<std::size_t>(at_[v]);
  if (prev_[v] != kNoNode) {
    next_[prev_[v]] = next_[v];
  } else {
    head_[l] = next_[v];
  }
  if (next_[v] != kNoNode) {
    prev_[next_[v]] = prev_[v];
  } else if (order_ == Order::kFirstFirst) {
    tail_[l] = prev_[v];
  }
  at_[v] = -1;
  --size_;
}

GainQueue::Item GainQueue::pop() noexcept {
  if (size_ == 0) {  // without a walk through all the empty lists
    top_ = -1;
    return {};
  }
  while (head_[static_cast<std::size_t>(top_)] == kNoNode) --top_;
  const NodeId v = head_[static_cast<std::size_t>(top_)];
  remove(v);
  return {v, top_ - kReach};
}

Refiner::Refiner(const Graph& graph, IdVector<NodeId, Rank>& part, std::vector<std::int64_t>& weight,
                 std::span<const std::int64_t> capacity, const IdVector<NodeId, char>* fixed)
    : g_(graph),
      part_(part),
      weight_(weight),
      capacity_(capacity),
      fixed_(fixed),
      queue_(graph.nodes()),
      contact_(weight.size(), 0),
      touched_(weight.size() + 1),
      locked_(graph.nodes(), 0) {}

Refiner::Target Refiner::best_target(NodeId v, bool any) noexcept {
  const std::span<const Edge> edges = g_.edges(v);
  const Rank own = part_[v];
  std::size_t touched = 0;
  for (const Edge& e : edges) {
    const Rank p = part_[e.to];
    std::int32_t& c = contact_[idx(p)];
    touched_[touched] = p;
    touched += c == 0 ? 1 : 0;
    c += e.weight;
  }
  const std::int64_t w = g_.weight[v], inner = contact_[idx(own)];
  contact_[idx(own)] = 0;
  Target best;
  for (std::size_t i = 0; i < touched; ++i) {
    const Rank p = touched_[i];
    const std::int64_t gain = contact_[idx(p)] - inner;
    contact_[idx(p)] = 0;
    if (p == own || (best.part != Rank{-1} && gain < best.gain)) continue;
    const std::int64_t after = weight_[idx(p)] + w;
    if (after > capacity_[idx(p)] && !(any && after < weight_[idx(own)])) continue;
    if (best.part == Rank{-1} || gain > best.gain || weight_[idx(p)] < weight_[idx(best.part)]) best = {p, gain};
  }
  return best;
}

bool Refiner::on_boundary(NodeId v) const noexcept {
  const Rank own = part_[v];
  return std::any_of(g_.edges(v).begin(), g_.edges(v).end(), [&](const Edge& e) { return part_[e.to] != own; });
}

void Refiner::move(NodeId v, Rank to) noexcept {
  weight_[idx(part_[v])] -= g_.weight[v];
  weight_[idx(to)] += g_.weight[v];
  part_[v] = to;
}

void Refiner::enqueue(NodeId v) {
  const Target t = best_target(v);
  if (t.part != Rank{-1}) queue_.push(v, t.gain);
}

void Refiner::update_neighbours(NodeId v) {
  for (const Edge& e : g_.edges(v)) {
    if (idx(e.to) >= g_.nodes() || locked_[e.to] != 0 || !may_move(e.to)) continue;
    if (queue_.has(e.to)) queue_.remove(e.to);
    enqueue(e.to);
  }
}

std::int64_t Refiner::search(std::size_t patience) {
  moves_.clear();
  std::int64_t gained = 0, best = 0;
  std::size_t best_moves = 0;
  for (;;) {
    const auto [v, expected] = queue_.pop();
    if (v == kNoNode) break;
    const Target t = best_target(v);
    if (t.part == Rank{-1}) continue;
    if (GainQueue::clamp(t.gain) < expected) {  // its part of choice has filled up
      queue_.push(v, t.gain);
      continue;
    }
    moves_.push_back({v, part_[v]});
    move(v, t.part);
    locked_[v] = 1;
    gained += t.gain;
    if (gained > best) {
      best = gained;
      best_moves = moves_.size();
    } else if (moves_.size() - best_moves > patience) {
      break;
    }
    update_neighbours(v);
  }
  while (queue_.pop().node != kNoNode) {
  }
  for (std::size_t i = moves_.size(); i-- > best_moves;) move(moves_[i].node, moves_[i].from);
  return best;
}

std::int64_t Refiner::global_pass(std::size_t patience) {
  for (const NodeId v : IdRange<NodeId>(g_.nodes())) {
    locked_[v] = 0;
    if (may_move(v) && on_boundary(v)) enqueue(v);
  }
  return search(patience);
}

std::int64_t Refiner::local_pass(std::size_t seeds, std::size_t patience) {
  std::vector<NodeId> boundary;
  for (const NodeId v : IdRange<NodeId>(g_.nodes())) {
    locked_[v] = 0;
    if (may_move(v) && on_boundary(v)) boundary.push_back(v);
  }
  std::int64_t gained = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    const NodeId v = boundary[i];
    if (locked_[v] == 0 && on_boundary(v) && !queue_.has(v)) {
      enqueue(v);
      ++n;
    }
    if (n < seeds && i + 1 < boundary.size()) continue;
    gained += search(patience);
    n = 0;
  }
  return gained;
}

bool Refiner::shed(bool any) {
  for (const NodeId v : IdRange<NodeId>(g_.nodes())) {
    locked_[v] = 0;
    if (weight_[idx(part_[v])] <= capacity_[idx(part_[v])] || g_.weight[v] == 0 || !may_move(v)) continue;
    const Target t = best_target(v, any);
    if (t.part != Rank{-1}) queue_.push(v, t.gain);
  }
  bool moved = false;
  for (;;) {
    const auto [v, expected] = queue_.pop();
    if (v == kNoNode) break;
    const Rank from = part_[v];
    if (weight_[idx(from)] <= capacity_[idx(from)]) continue;
    const Target t = best_target(v, any);
    if (t.part == Rank{-1}) continue;
    if (GainQueue::clamp(t.gain) < expected) {
      queue_.push(v, t.gain);
      continue;
    }
    move(v, t.part);
    locked_[v] = 1;
    moved = true;
    for (const Edge& e : g_.edges(v)) {
      if (idx(e.to) >= g_.nodes() || locked_[e.to] != 0 || !may_move(e.to) || part_[e.to] != from) continue;
      if (queue_.has(e.to)) queue_.remove(e.to);
      const Target next = best_target(e.to, any);
      if (next.part != Rank{-1}) queue_.push(e.to, next.gain);
    }
  }
  return moved;
}

void Refiner::balance() {
  const auto over = [&] {
    for (std::size_t p = 0; p < weight_.size(); ++p) {
      if (weight_[p] > capacity_[p]) return true;
    }
    return false;
  };
  constexpr int kRounds = 10;  // each may pass the surplus on to the next part
  for (int r = 0; r < kRounds && over(); ++r) {
    if (!shed(false) && !shed(true)) break;
  }
}

}  // namespace skein
