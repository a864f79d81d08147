// Winners: which of the two ranks that share an interface takes the region along it.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// A priority that is the larger, the smaller the amount. Priorities of different ranks differ; all are greater than 0;
/// the low 32 bits are the rank. @pre amount >= 0.
[[nodiscard]] constexpr std::int64_t least_first(std::int64_t amount, Rank r) noexcept {
  constexpr std::int64_t kMost = (std::int64_t{1} << 29) - 1;  // leaves two bits above for others
  return (kMost + 1 - (amount < kMost ? amount : kMost)) << 32 | num(r);
}

/// Of every two ranks that share vertices one is the winner and takes them all. So an interface goes to one rank as a
/// whole, and regions of different winners touch only where three ranks meet. Winners are chosen so that all ranks win
/// about as many vertices; ties are broken differently in each round. Where there are fewer pairs than ranks, as with
/// two ranks, the box of a large interface is halved, and each half has a winner of its own.
class Winners {
 public:
  /// Collective. `wanted`: one per entry of dist.sharing, nonzero for the vertices that count; alike on all copies.
  Winners(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted, int round);
  /// The rank that gets the vertex of entry i of dist.sharing, at x; the same on all that share it. Not collective.
  [[nodiscard]] Rank winner(const Sharing& sharing, std::size_t i, Vec3 x) const;
  /// Priority of rank r where the regions of two winners meet: larger for a rank that has won fewer vertices. See
  /// least_first(). Not collective.
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
  /// Exchanges winner and loser of single pairs, and of two pairs at once, while the ranks' shares become more equal.
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
