// Winners: which of the ranks that share an interface shall have what lies along it.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Orders ranks by some amount, the least first: distinct, greater than 0, the rank in the low 32 bits. @pre amount >=
/// 0.
[[nodiscard]] constexpr std::int64_t least_first(std::int64_t amount, Rank r) noexcept {
  constexpr std::int64_t kMost = (std::int64_t{1} << 29) - 1;  // leaves two bits above for others
  return (kMost + 1 - (amount < kMost ? amount : kMost)) << 32 | num(r);
}

/// Every two ranks that share vertices fight for them, and one wins them all: an interface is then given away in one
/// piece, and only where three ranks meet do regions of different winners touch. Who wins is chosen so that all ranks
/// win about as many vertices; among equals it changes with the round. Where there are fewer pairs than ranks, as with
/// two ranks, the halves of the interface's box are fought for apart, if it is not small.
class Winners {
 public:
  /// Collective. `wanted`: one per entry of dist.sharing, nonzero for the vertices that count; alike on all copies.
  Winners(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted, int round);
  /// The rank that gets the vertex of entry i of dist.sharing, at x; the same on all that share it. Not collective.
  [[nodiscard]] Rank winner(const Sharing& sharing, std::size_t i, Vec3 x) const;
  /// Who goes first where the regions of two winners meet: who has won less. Distinct, greater than 0, the rank in the
  /// low 32 bits. Not collective.
  [[nodiscard]] std::int64_t priority(Rank r) const noexcept { return least_first(won_[idx(r)], r); }

 private:
  struct RankPair {
    Rank a, b;  ///< a < b
    std::int32_t half;
    std::int32_t b_wins;
    std::int64_t verts;
    [[nodiscard]] Rank winner() const noexcept { return b_wins != 0 ? b : a; }
    [[nodiscard]] Rank loser() const noexcept { return b_wins != 0 ? a : b; }
  };
  void find_box(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted);
  void count(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted);
  void decide(int ranks);
  /// Turns round single winners, and pairs of them that a rank wins and loses, for as long as shares become more alike.
  void make_alike();
  [[nodiscard]] std::int32_t half_of(Vec3 x) const noexcept;
  [[nodiscard]] bool beats(Rank r, Rank other, std::int32_t half) const noexcept;

  Rank self_;
  int round_;
  std::size_t axis_ = 0;  ///< across which the box is halved
  double middle_ = 0;
  std::int64_t copies_ = 0;  ///< of all wanted vertices
  bool halved_ = true;
  std::vector<RankPair> pairs_;    ///< by a, b, half; the same on all ranks
  std::vector<std::int64_t> won_;  ///< vertices, by rank
};

}  // namespace skein
