// Winners: one winner everywhere, the interface of two ranks in one piece, and shares that no exchange makes more
// alike.
#include "dist/winners.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "dist/partition.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

DistMesh parted(const Comm& comm, int n) {
  DistMesh dist = distribute(comm, slices(comm, cube(n)));
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  migrate(comm, dist, partition(comm, dist, work, comm.size(), PartitionMethod::kMultilevel));
  return dist;
}

/// Per entry of dist.sharing.
std::vector<Rank> winners(const DistMesh& dist, const Winners& contest) {
  std::vector<Rank> out;
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) {
    out.push_back(contest.winner(dist.sharing, i, dist.mesh.coords[dist.sharing.vert[i]]));
  }
  return out;
}

struct Shared {
  GlobalId gid;
  Rank a, b;  ///< the two that share it; b = Rank{-1}: more do
  Rank winner;
};
/// Collective. All copies of all shared vertices, as their ranks see them.
std::vector<Shared> all_shared(const Comm& comm, const DistMesh& dist, const Winners& contest) {
  std::vector<Shared> own;
  const auto win = winners(dist, contest);
  for (std::size_t i = 0; i < win.size(); ++i) {
    const auto others = dist.sharing.others(i);
    const Rank a = std::min(comm.rank(), others.front()), b = std::max(comm.rank(), others.front());
    own.push_back({dist.sharing.gid[i], a, others.size() == 1 ? b : Rank{-1}, win[i]});
    EXPECT_TRUE(win[i] == comm.rank() || std::find(others.begin(), others.end(), win[i]) != others.end());
  }
  return comm.all_gather(own);
}

TEST(Winners, HaveOneWinnerOnAllCopies) {
  const Comm& comm = world();
  const DistMesh dist = parted(comm, 8);
  const Winners contest(comm, dist, std::vector<char>(dist.sharing.size(), 1), 1);
  std::map<GlobalId, Rank> winner;
  std::map<std::pair<Rank, Rank>, std::set<Rank>> of_pair;
  for (const Shared& s : all_shared(comm, dist, contest)) {
    EXPECT_EQ(winner.try_emplace(s.gid, s.winner).first->second, s.winner);
    if (s.b != Rank{-1}) of_pair[{s.a, s.b}].insert(s.winner);
  }
  for (const auto& [pair, who] : of_pair) {
    if (comm.size() > 2) {
      EXPECT_LE(who.size(), of_pair.size() < static_cast<std::size_t>(comm.size()) ? 2U : 1U);
    }
  }
}

TEST(Winners, GiveSharesThatNoSingleExchangeMakesMoreAlike) {
  const Comm& comm = world();
  const DistMesh dist = parted(comm, 10);
  const Winners contest(comm, dist, std::vector<char>(dist.sharing.size(), 1), 1);
  std::map<Rank, std::int64_t> won;
  std::map<std::pair<Rank, Rank>, std::int64_t> stake;  // winner, loser
  std::set<GlobalId> seen;
  for (const Shared& s : all_shared(comm, dist, contest)) {
    if (s.b == Rank{-1} || !seen.insert(s.gid).second) continue;
    ++won[s.winner];
    ++stake[{s.winner, s.winner == s.a ? s.b : s.a}];
  }
  for (const auto& [who, verts] : stake) EXPECT_LE(won[who.first] - won[who.second], verts);
}

TEST(Winners, ShareOutALargeInterfaceOfTwo) {
  const Comm& comm = world();
  if (comm.size() != 2) return;
  const DistMesh dist = parted(comm, 30);
  ASSERT_GE(dist.sharing.size(), 900u);
  const Winners contest(comm, dist, std::vector<char>(dist.sharing.size(), 1), 1);
  const auto win = winners(dist, contest);
  const auto first = std::count(win.begin(), win.end(), Rank{0});
  EXPECT_GE(3 * first, std::ssize(win));
  EXPECT_LE(3 * first, 2 * std::ssize(win));
}

TEST(Winners, CountWhatIsWantedOnly) {
  const Comm& comm = world();
  const DistMesh dist = parted(comm, 6);
  const Winners contest(comm, dist, std::vector<char>(dist.sharing.size(), 0), 1);
  for (const Rank r : {Rank{0}, comm.rank()}) {
    EXPECT_GT(contest.priority(r), 0);
    EXPECT_EQ(Rank{static_cast<std::int32_t>(contest.priority(r) & 0xffffffff)}, r);
  }
  EXPECT_EQ(winners(dist, contest).size(), dist.sharing.size());
}

}  // namespace
}  // namespace skein::test
