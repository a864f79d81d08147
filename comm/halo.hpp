// Halo: exchange of values at shared vertices, after which all copies have the same bits.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "comm/exchange.hpp"

namespace skein {

/// The shared vertices of this rank, and the ranks that share them. Entry i is vertex vert[i] with global id gid[i];
/// entries are ascending by global id. The other ranks that have a copy of it are rank[offset[i] .. offset[i+1]),
/// ascending.
struct Sharing {
  std::vector<VertId> vert;
  std::vector<GlobalId> gid;
  std::vector<std::size_t> offset{0};
  std::vector<Rank> rank;
  [[nodiscard]] std::size_t size() const noexcept { return vert.size(); }
  [[nodiscard]] std::span<const Rank> others(std::size_t i) const noexcept {
    return {rank.data() + offset[i], offset[i + 1] - offset[i]};
  }
  /// The owner of a shared vertex is the lowest rank that has it. Tells whether `self`, this rank, owns vert[i].
  [[nodiscard]] bool owned(std::size_t i, Rank self) const noexcept { return self < rank[offset[i]]; }
};

/// Exchanges values at shared vertices. Every operation combines the copies in ascending rank order, so that all
/// copies end with the same bits. The lists are made once; each call is one exchange with the neighbour ranks.
class Halo {
 public:
  /// Collective. @pre sharing is consistent: if a rank names another for a vertex, that one names it back. Throws
  /// Error(kInternal) on all ranks when it is not. `comm` must outlive the Halo.
  Halo(const Comm& comm, const Sharing& sharing);

  /// Collective. values: `width` numbers per local vertex, vertex after vertex.
  template <Reducible T>
  void sum(std::span<T> values, int width = 1) const {
    combine<T>(at_vertex(values, width), width, Op::kSum);
  }
  template <Reducible T>
  void min(std::span<T> values, int width = 1) const {
    combine<T>(at_vertex(values, width), width, Op::kMin);
  }
  template <Reducible T>
  void max(std::span<T> values, int width = 1) const {
    combine<T>(at_vertex(values, width), width, Op::kMax);
  }
  /// Collective. The lowest rank's copy everywhere.
  template <Reducible T>
  void copy_from_owner(std::span<T> values, int width = 1) const;
  /// Collective. values: one number per shared vertex, in the order of the Sharing.
  template <Reducible T>
  void sum_shared(std::span<T> values) const {
    combine<T>(at_entry(values), 1, Op::kSum);
  }
  template <Reducible T>
  void max_shared(std::span<T> values) const {
    combine<T>(at_entry(values), 1, Op::kMax);
  }
  /// Collective. The same; every copy gets the bits that any copy has.
  template <Reducible T>
  void or_shared(std::span<T> bits) const {
    fold_copies<T>(at_entry(bits), 1, [](T a, T b) { return a | b; });
  }

 private:
  // Where the numbers of shared vertex i are.
  template <Reducible T>
  auto at_vertex(std::span<T> values, int width) const {
    return [=, this](std::size_t i) { return values.data() + idx(sharing_.vert[i]) * static_cast<std::size_t>(width); };
  }
  template <Reducible T>
  static auto at_entry(std::span<T> values) {
    return [=](std::size_t i) { return values.data() + i; };
  }
  template <Reducible T, class At>
  void combine(At at, int width, Op op) const;
  /// total = fold(...fold(copy of lowest rank, next)..., copy of highest rank) at every shared vertex: `width` numbers
  /// from at(i) on.
  template <Reducible T, class At, class Fold>
  void fold_copies(At at, int width, Fold fold) const;
  /// Sends in[k] of `item` bytes to the neighbour of entry k, and takes its copy into out[k].
  void exchange_bytes(const void* in, void* out, std::size_t item) const;

  const Comm* comm_;
  Sharing sharing_;
  // Per neighbour rank (ascending) the shared vertices, ascending by global id, so in the same order on both sides:
  // entry_[offset_[n] .. offset_[n+1]) are indices into sharing_.
  std::vector<Rank> neighbour_;
  std::vector<std::size_t> offset_{0};
  std::vector<std::size_t> entry_;
};

}  // namespace skein

#include "comm/halo_inl.hpp"
