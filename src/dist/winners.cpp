// Counting what is fought for, and choosing winners.
#include "dist/winners.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "base/add_up.hpp"
#include "dist/rendezvous.hpp"

namespace skein {
namespace {

constexpr std::int64_t kSmallest = 1600;  ///< copies of shared vertices below which an interface stays in one piece
constexpr int kTurns = 8;  ///< of turning winners round that make the winner's and the loser's share unlike

std::array<double, 3> parts_of(Vec3 x) noexcept { return {x.x, x.y, x.z}; }

/// An order of the ranks, another one in each round: distinct, greater than 0, the rank in the low 32 bits.
std::int64_t order_in_round(Rank r, int round) noexcept {
  const std::uint64_t h = mix(mix(static_cast<std::uint64_t>(round) + 1) ^ static_cast<std::uint64_t>(num(r)));
  return static_cast<std::int64_t>((h >> 34 | 1) << 32) | num(r);
}

}  // namespace

Winners::Winners(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted, int round)
    : self_(comm.rank()), round_(round) {
  find_box(comm, dist, wanted);
  count(comm, dist, wanted);
  decide(comm.size());
}

void Winners::find_box(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted) {
  constexpr double kBig = 1e300;
  std::array<double, 6> low{kBig, kBig, kBig, kBig, kBig, kBig};  // the last three are those of -x
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == 0) continue;
    ++copies_;
    const auto x = parts_of(dist.mesh.coords[dist.sharing.vert[i]]);
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      low[k + 3] = std::min(low[k + 3], -x[k]);
    }
  }
  comm.reduce(std::span<double>(low), Op::kMin);
  copies_ = comm.sum(copies_);
  const auto width = [&](std::size_t k) { return -low[k + 3] - low[k]; };
  for (std::size_t k = 1; k < 3; ++k) {
    if (width(k) > width(axis_)) axis_ = k;
  }
  middle_ = 0.5 * (low[axis_] - low[axis_ + 3]);
}

std::int32_t Winners::half_of(Vec3 x) const noexcept { return halved_ && parts_of(x)[axis_] > middle_ ? 1 : 0; }

void Winners::count(const Comm& comm, const DistMesh& dist, const std::vector<char>& wanted) {
  const Sharing& s = dist.sharing;
  const auto key = [](const RankPair& d) { return std::tuple(d.a, d.b, d.half); };
  std::vector<RankPair> own;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == 0 || s.others(i).size() != 1 || !s.owned(i, self_)) continue;
    own.push_back({self_, s.others(i).front(), half_of(dist.mesh.coords[s.vert[i]]), 0, 1});
  }
  add_up(own, key, &RankPair::verts);
  pairs_ = comm.all_gather(own);
  std::vector<char> fights(static_cast<std::size_t>(comm.size()), 0);
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const RankPair& d = pairs_[i];
    if (i == 0 || pairs_[i - 1].a != d.a || pairs_[i - 1].b != d.b) ++pairs;
    fights[idx(d.a)] = fights[idx(d.b)] = 1;
  }
  const auto fighters = static_cast<std::size_t>(std::count(fights.begin(), fights.end(), 1));
  halved_ = pairs < fighters && copies_ >= kSmallest;
  if (halved_) return;
  for (RankPair& d : pairs_) d.half = 0;
  add_up(pairs_, key, &RankPair::verts);
}

void Winners::decide(int ranks) {
  won_.assign(static_cast<std::size_t>(ranks), 0);
  std::vector<std::size_t> order(pairs_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return pairs_[i].verts > pairs_[j].verts; });
  for (const std::size_t i : order) {
    RankPair& d = pairs_[i];
    const std::int64_t a = won_[idx(d.a)], b = won_[idx(d.b)];
    d.b_wins = a != b ? a > b : order_in_round(d.a, round_) < order_in_round(d.b, round_);
    won_[idx(d.winner())] += d.verts;
  }
  make_alike();
}

void Winners::make_alike() {
  std::vector<std::vector<std::size_t>> of_rank(won_.size());
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    of_rank[idx(pairs_[i].a)].push_back(i);
    of_rank[idx(pairs_[i].b)].push_back(i);
  }
  const auto turn_round = [&](RankPair& d) {
    won_[idx(d.winner())] -= d.verts;
    won_[idx(d.loser())] += d.verts;
    d.b_wins ^= 1;
  };
  // Half of what the sum of squares falls by when x gives so much to y.
  const auto gain = [](std::int64_t x, std::int64_t y, std::int64_t verts) { return (x - y - verts) * verts; };
  bool any = true;
  for (int turn = 0; any && turn < kTurns; ++turn) {
    any = false;
    for (RankPair& d : pairs_) {
      const std::int64_t top = won_[idx(d.winner())], middle = won_[idx(d.loser())];
      std::int64_t best = gain(top, middle, d.verts);
      RankPair* next = nullptr;  // what the loser might give away in return
      for (const std::size_t i : of_rank[idx(d.loser())]) {
        RankPair& e = pairs_[i];
        if (e.winner() != d.loser() || e.loser() == d.winner()) continue;
        const std::int64_t both = gain(top, middle, d.verts) + gain(middle + d.verts, won_[idx(e.loser())], e.verts);
        if (both > best) best = both, next = &e;
      }
      if (best <= 0) continue;
      any = true;
      turn_round(d);
      if (next != nullptr) turn_round(*next);
    }
  }
}

bool Winners::beats(Rank r, Rank other, std::int32_t half) const noexcept {
  const auto wanted = std::tuple(std::min(r, other), std::max(r, other), half);
  const auto at = std::lower_bound(pairs_.begin(), pairs_.end(), wanted,
                                   [](const RankPair& d, const auto& w) { return std::tuple(d.a, d.b, d.half) < w; });
  if (at == pairs_.end() || std::tuple(at->a, at->b, at->half) != wanted) return true;  // they share no vertex alone
  return at->winner() == r;
}

Rank Winners::winner(const Sharing& sharing, std::size_t i, Vec3 x) const {
  // Where more than two meet: who beats all others there, else who has won least.
  const auto others = sharing.others(i);
  const std::int32_t half = half_of(x);
  std::int64_t best = 0;
  for (std::size_t k = 0; k <= others.size(); ++k) {
    const Rank r = k == 0 ? self_ : others[k - 1];
    const auto beaten = [&](Rank o) { return o == r || beats(r, o, half); };
    const bool all = beaten(self_) && std::all_of(others.begin(), others.end(), beaten);
    constexpr std::int64_t kBeatsAll = std::int64_t{1} << 62;
    best = std::max(best, priority(r) | (all ? kBeatsAll : 0));
  }
  return to_id<Rank>(best & 0xffffffff);
}

}  // namespace skein
