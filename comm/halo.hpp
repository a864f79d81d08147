// Halo: values at the vertices that several ranks share, brought to the same bits on every copy.
#pragma once
#include <span>
#include <vector>

#include "comm/exchange.hpp"

namespace skein {

/// Which vertices this rank shares with whom. vert[i] ascending by global id, gid[i] its global id; the other ranks that have a copy
/// are rank[offset[i] .. offset[i+1]), ascending, without this rank.
struct Sharing {
  std::vector<VertId> vert;
  std::vector<GlobalId> gid;
  std::vector<std::size_t> offset{0};
  std::vector<Rank> rank;
  [[nodiscard]] std::size_t size() const noexcept { return vert.size(); }
  [[nodiscard]] std::span<const Rank> others(std::size_t i) const noexcept {
    return {rank.data() + offset[i], offset[i + 1] - offset[i]};
  }
};

/// Exchanges values at shared vertices. Every operation combines the copies in ascending rank order, so that all
/// copies end with the same bits. The lists are made once; each call is one exchange with the neighbour ranks.
class Halo {
 public:
  /// Collective. @pre sharing is consistent: if a rank names another for a vertex, that one names it back.
  Halo(const Comm& comm, const Sharing& sharing);

  /// Collective. values: `width` numbers per local vertex, vertex after vertex.
  template <Reducible T>
  void sum(std::span<T> values, int width = 1) const { combine(values, width, Op::kSum); }
  template <Reducible T>
  void min(std::span<T> values, int width = 1) const { combine(values, width, Op::kMin); }
  template <Reducible T>
  void max(std::span<T> values, int width = 1) const { combine(values, width, Op::kMax); }
  /// Collective. The lowest rank's copy everywhere.
  template <Reducible T>
  void copy_from_owner(std::span<T> values, int width = 1) const;

 private:
  template <Reducible T>
  void combine(std::span<T> values, int width, Op op) const;
  const Comm* comm_;
  // per neighbour rank: the shared vertices in ascending global id (same order on both sides)
  std::vector<Rank> neighbour_;
  std::vector<std::size_t> offset_;
  std::vector<VertId> vert_;
  Sharing sharing_;
};

}  // namespace skein

#include "comm/halo_inl.hpp"
