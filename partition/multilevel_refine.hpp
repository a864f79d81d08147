// Better parts by moving single nodes: local search between all parts at once [FiducciaMattheyses1982].
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "partition/graph.hpp"

namespace skein {

/// A queue of nodes ordered by gain: a list per gain. Nodes of equal gain leave last-in first-out, which keeps a search
/// in one place, or first-in first-out, so that a growing part grows in layers. Gains beyond +-kReach share the
/// outermost lists.
class GainQueue {
 public:
  enum class Order { kLastFirst, kFirstFirst };
  explicit GainQueue(std::size_t nodes, Order order = Order::kLastFirst);
  void push(NodeId v, std::int64_t gain) noexcept;
  void remove(NodeId v) noexcept;
  struct Item {
    NodeId node = kNoNode;  ///< kNoNode when the queue is empty
    std::int32_t gain = 0;  ///< that it was pushed with, clamped
  };
  Item pop() noexcept;
  [[nodiscard]] bool has(NodeId v) const noexcept { return at_[v].list >= 0; }
  static constexpr std::int32_t kReach = 2000;
  static std::int32_t clamp(std::int64_t gain) noexcept;

 private:
  struct Place {
    NodeId next = kNoNode, prev = kNoNode;
    std::int32_t list = -1;  ///< -1: not in the queue
  };
  IdVector<NodeId, Place> at_;
  std::vector<NodeId> head_, tail_;  ///< the tails only in kFirstFirst
  Order order_;
  std::int32_t top_ = -1;
  std::size_t size_ = 0;
};

/// Moves own nodes of a graph between parts; ghosts and fixed nodes stay. Deterministic.
class Refiner {
 public:
  /// `part`: one per own node and ghost; changed in place. `weight`: of each part. `capacity`: the largest weight that
  /// a part may reach. `fixed`: null, or nonzero for nodes that stay. References must outlive this object. `threads`
  /// threads look for the boundary; the result does not depend on them.
  Refiner(const Graph& graph, IdVector<NodeId, PartId>& part, std::vector<std::int64_t>& weight,
          std::span<const std::int64_t> capacity, const IdVector<NodeId, char>* fixed = nullptr, int threads = 1);

  /// Takes nodes from parts beyond their capacity to neighbours that have room, cheapest first.
  void balance();
  /// One search that starts with all nodes of the boundary. It moves the node of the largest gain, also when the gain
  /// is negative, each node at most once. It stops when `patience` moves in a row have not improved the cut, or when an
  /// improvement has become unlikely [OsipovSanders2010]; then it returns to the best state. Returns the decrease of
  /// the cut.
  std::int64_t global_pass(std::size_t patience);
  /// Many small such searches, each from a few neighbouring nodes of the boundary.
  std::int64_t local_pass(std::size_t seeds, std::size_t patience);

 private:
  struct Target {
    PartId part = kNoPart;
    std::int32_t gain = 0;
  };
  /// Where a node may move to.
  enum class Where : std::uint8_t {
    kRoomy,          ///< parts with room for it
    kRoomyOrLighter  ///< also parts without room that stay lighter than its own
  };
  /// Bits of state_.
  enum : std::uint8_t { kLocked = 1, kFixed = 2, kMaybeBoundary = 4 };

  /// The best part for v to move to. kNoPart: none.
  Target best_target(NodeId v, Where where = Where::kRoomy) noexcept;
  [[nodiscard]] bool on_boundary(NodeId v) const noexcept;
  /// The nodes that a pass may start from, in their order; unlocks all nodes.
  void find_boundary();
  void move(NodeId v, PartId to) noexcept;
  bool enqueue(NodeId v, Where where = Where::kRoomy);
  void update_neighbours(NodeId v);
  std::int64_t search(std::size_t patience);
  bool shed(Where where);

  const Graph& g_;
  IdVector<NodeId, PartId>& part_;
  std::vector<std::int64_t>& weight_;
  std::span<const std::int64_t> capacity_;
  GainQueue queue_;
  std::vector<std::int32_t> contact_;  ///< by part; zero but inside best_target
  std::vector<PartId> touched_;
  IdVector<NodeId, Target> target_;  ///< of the nodes in the queue
  IdVector<NodeId, std::uint8_t> state_;
  std::vector<NodeId> boundary_;
  std::vector<std::vector<NodeId>> boundary_of_;  ///< the same, by thread
  struct Move {
    NodeId node;
    PartId from;
  };
  std::vector<Move> moves_;
};

}  // namespace skein
