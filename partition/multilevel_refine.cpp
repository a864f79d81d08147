// Local search between parts.
#include "partition/multilevel_refine.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace skein {

GainQueue::GainQueue(std::size_t nodes, Order order) : at_(nodes), head_(2 * kReach + 1, kNoNode), order_(order) {
  if (order == Order::kFirstFirst) tail_.assign(head_.size(), kNoNode);
}

std::int32_t GainQueue::clamp(std::int64_t gain) noexcept {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(gain, -kReach, kReach));
}

void GainQueue::push(NodeId v, std::int64_t gain) noexcept {
  const std::int32_t list = clamp(gain) + kReach;
  top_ = std::max(top_, list);
  ++size_;
  const auto l = static_cast<std::size_t>(list);
  NodeId& head = head_[l];
  if (order_ == Order::kLastFirst || head == kNoNode) {
    at_[v] = {head, kNoNode, list};
    if (head != kNoNode) at_[head].prev = v;
    head = v;
    if (order_ == Order::kFirstFirst) tail_[l] = v;
  } else {
    at_[v] = {kNoNode, tail_[l], list};
    at_[tail_[l]].next = v;
    tail_[l] = v;
  }
}

void GainQueue::remove(NodeId v) noexcept {
  Place& p = at_[v];
  const auto l = static_cast<std::size_t>(p.list);
  if (p.prev != kNoNode) {
    at_[p.prev].next = p.next;
  } else {
    head_[l] = p.next;
  }
  if (p.next != kNoNode) {
    at_[p.next].prev = p.prev;
  } else if (order_ == Order::kFirstFirst) {
    tail_[l] = p.prev;
  }
  p.list = -1;
  --size_;
}

GainQueue::Item GainQueue::pop() noexcept {
  if (size_ == 0) {  // without a walk through all the empty lists
    top_ = -1;
    return {};
  }
  while (head_[top_] == kNoNode) --top_;
  const NodeId v = head_[top_];
  remove(v);
  return {v, top_ - kReach};
}

Refiner::Refiner(const Graph& graph, IdVector<NodeId, PartId>& part, std::vector<std::int64_t>& weight,
                 std::span<const std::int64_t> capacity, const IdVector<NodeId, char>* fixed, int threads)
    : g_(graph),
      part_(part),
      weight_(weight),
      capacity_(capacity),
      queue_(graph.nodes()),
      contact_(weight.size(), 0),
      touched_(weight.size() + 1),
      target_(graph.nodes()),
      state_(graph.nodes(), kMaybeBoundary),
      boundary_of_(static_cast<std::size_t>(threads_for(graph.nodes(), threads))) {
  if (fixed == nullptr) return;
  for (const NodeId v : IdRange<NodeId>(graph.nodes())) state_[v] = (*fixed)[v] != 0 ? kFixed : kMaybeBoundary;
}

Refiner::Target Refiner::best_target(NodeId v, Where where) noexcept {
  const std::span<const Edge> edges = g_.edges(v);
  const PartId own = part_[v];
  std::size_t touched = 0;
  for (const Edge& e : edges) {
    const PartId p = part_[e.to];
    std::int32_t& c = contact_[idx(p)];
    touched_[touched] = p;
    touched += c == 0 ? 1 : 0;
    c += e.weight;
  }
  const std::int64_t w = g_.weight[v];
  const std::int32_t inner = contact_[idx(own)];
  contact_[idx(own)] = 0;
  const bool lighter_too = where == Where::kRoomyOrLighter;
  Target best;
  for (std::size_t i = 0; i < touched; ++i) {
    const PartId p = touched_[i];
    const std::int32_t gain = contact_[idx(p)] - inner;
    contact_[idx(p)] = 0;
    if (p == own || (best.part != kNoPart && gain < best.gain)) continue;
    const std::int64_t after = weight_[idx(p)] + w;
    if (after > capacity_[idx(p)] && !(lighter_too && after < weight_[idx(own)])) continue;
    if (best.part == kNoPart || gain > best.gain || weight_[idx(p)] < weight_[idx(best.part)]) best = {p, gain};
  }
  return best;
}

bool Refiner::on_boundary(NodeId v) const noexcept {
  const auto own = static_cast<std::uint32_t>(part_[v]);
  std::uint32_t differ = 0;  // no early exit: where it comes cannot be foreseen, and rows are short
  for (const Edge& e : g_.edges(v)) differ |= static_cast<std::uint32_t>(part_[e.to]) ^ own;
  return differ != 0;
}

void Refiner::find_boundary() {
  const int threads = static_cast<int>(boundary_of_.size());
  in_parallel(threads, [&](int w) {
    auto& found = boundary_of_[w];
    found.clear();
    for (const NodeId v :
         IdRange<NodeId>(share_begin(g_.nodes(), w, threads), share_begin(g_.nodes(), w + 1, threads))) {
      std::uint8_t& s = state_[v];
      s &= static_cast<std::uint8_t>(~kLocked);
      if ((s & kMaybeBoundary) == 0) continue;
      if (on_boundary(v)) {
        found.push_back(v);
      } else {
        s = 0;
      }
    }
  });
  boundary_.clear();
  for (const auto& found : boundary_of_) boundary_.insert(boundary_.end(), found.begin(), found.end());
}

void Refiner::move(NodeId v, PartId to) noexcept {
  weight_[idx(part_[v])] -= g_.weight[v];
  weight_[idx(to)] += g_.weight[v];
  part_[v] = to;
}

bool Refiner::enqueue(NodeId v, Where where) {
  const Target t = target_[v] = best_target(v, where);
  if (t.part == kNoPart) return false;
  queue_.push(v, t.gain);
  return true;
}

void Refiner::update_neighbours(NodeId v) {
  for (const Edge& e : g_.edges(v)) {
    if (idx(e.to) >= g_.nodes()) continue;
    std::uint8_t& s = state_[e.to];
    if ((s & (kFixed | kLocked)) != 0) continue;  // what is locked is marked already
    s = kMaybeBoundary;
    if (queue_.has(e.to)) queue_.remove(e.to);
    enqueue(e.to);
  }
}

namespace {

/// The moves of a search since its best state. If they were a random walk of steps like those so far, is it unlikely to
/// come back? [OsipovSanders2010, section 5]
class Walk {
 public:
  void restart() noexcept { *this = {}; }
  void step(std::int64_t gain) noexcept {
    const auto g = static_cast<double>(gain);
    steps_ += 1;
    sum_ += g;
    squares_ += g * g;
  }
  [[nodiscard]] bool hopeless() const noexcept {
    constexpr double kDoubt = 2;
    constexpr double kFewest = 3;  // fewer steps say nothing
    const double mean = sum_ / steps_, variance = squares_ / steps_ - mean * mean;
    return steps_ >= kFewest && steps_ * mean * mean > kDoubt * variance;
  }

 private:
  double steps_ = 0, sum_ = 0, squares_ = 0;
};

}  // namespace

std::int64_t Refiner::search(std::size_t patience) {
  moves_.clear();
  std::int64_t gained = 0, best = 0;
  std::size_t best_moves = 0;
  Walk walk;
  for (;;) {
    const auto [v, expected] = queue_.pop();
    if (v == kNoNode) break;
    Target t = target_[v];
    if (weight_[idx(t.part)] + g_.weight[v] > capacity_[idx(t.part)]) {  // it has filled up
      t = target_[v] = best_target(v);
      if (t.part == kNoPart) continue;
      if (GainQueue::clamp(t.gain) < expected) {
        queue_.push(v, t.gain);
        continue;
      }
    }
    moves_.push_back({v, part_[v]});
    move(v, t.part);
    state_[v] |= kLocked;
    gained += t.gain;
    walk.step(t.gain);
    if (gained > best) {
      best = gained;
      best_moves = moves_.size();
      walk.restart();
    } else if (moves_.size() - best_moves > patience || walk.hopeless()) {
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
  find_boundary();
  for (const NodeId v : boundary_) enqueue(v);
  return search(patience);
}

std::int64_t Refiner::local_pass(std::size_t seeds, std::size_t patience) {
  find_boundary();
  std::int64_t gained = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < boundary_.size(); ++i) {
    const NodeId v = boundary_[i];
    if ((state_[v] & kLocked) == 0 && !queue_.has(v) && enqueue(v)) ++n;
    if (n < seeds && i + 1 < boundary_.size()) continue;
    gained += search(patience);
    n = 0;
  }
  return gained;
}

bool Refiner::shed(Where where) {
  for (const NodeId v : IdRange<NodeId>(g_.nodes())) {
    state_[v] &= static_cast<std::uint8_t>(~kLocked);
    if (weight_[idx(part_[v])] <= capacity_[idx(part_[v])] || g_.weight[v] == 0 || (state_[v] & kFixed) != 0) continue;
    enqueue(v, where);
  }
  bool moved = false;
  for (;;) {
    const auto [v, expected] = queue_.pop();
    if (v == kNoNode) break;
    const PartId from = part_[v];
    if (weight_[idx(from)] <= capacity_[idx(from)]) continue;
    const Target t = best_target(v, where);
    if (t.part == kNoPart) continue;
    if (GainQueue::clamp(t.gain) < expected) {
      queue_.push(v, t.gain);
      continue;
    }
    move(v, t.part);
    state_[v] |= kLocked;
    moved = true;
    for (const Edge& e : g_.edges(v)) {
      if (idx(e.to) >= g_.nodes() || (state_[e.to] & kFixed) != 0) continue;
      state_[e.to] |= kMaybeBoundary;
      if ((state_[e.to] & kLocked) != 0 || part_[e.to] != from) continue;
      if (queue_.has(e.to)) queue_.remove(e.to);
      enqueue(e.to, where);
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
    if (!shed(Where::kRoomy) && !shed(Where::kRoomyOrLighter)) break;
  }
}

}  // namespace skein
