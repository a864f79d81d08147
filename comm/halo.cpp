// The lists of a Halo, and their exchange.
#include "comm/halo.hpp"

#include <fmt/format.h>

namespace skein {
namespace {

std::string pair_error(Rank self, Rank other, const std::string& what) {
  return fmt::format("shared vertices of ranks {} and {}: {}", num(self), num(other), what);
}

/// Both sides must list the same global ids; otherwise later exchanges would mix up values or never end.
void check_sharing(const Comm& comm, const Packets<GlobalId>& mine) {
  const Packets<GlobalId> theirs = exchange(comm, mine);
  agree(comm, [&] {
    if (std::find(mine.rank.begin(), mine.rank.end(), comm.rank()) != mine.rank.end())
      throw Error(ExitCode::kInternal, pair_error(comm.rank(), comm.rank(), "a rank names itself"));
    std::size_t i = 0, j = 0;
    while (i < mine.blocks() || j < theirs.blocks()) {
      const bool left = j == theirs.blocks() || (i < mine.blocks() && mine.rank[i] < theirs.rank[j]);
      const bool right = i == mine.blocks() || (j < theirs.blocks() && theirs.rank[j] < mine.rank[i]);
      if (left || right) {
        const Rank other = left ? mine.rank[i] : theirs.rank[j];
        throw Error(ExitCode::kInternal, pair_error(comm.rank(), other, "only one of them names the other"));
      }
      const auto a = mine.block(i), b = theirs.block(j);
      if (!std::equal(a.begin(), a.end(), b.begin(), b.end()))
        throw Error(ExitCode::kInternal, pair_error(comm.rank(), mine.rank[i], "their lists differ"));
      ++i, ++j;
    }
  });
}

}  // namespace

Halo::Halo(const Comm& comm, const Sharing& sharing) : comm_(&comm), sharing_(sharing) {
  // One item per copy elsewhere; pack() sorts by rank and keeps the ascending global ids within a rank.
  std::vector<std::size_t> entry;
  entry.reserve(sharing.rank.size());
  for (std::size_t i = 0; i < sharing.size(); ++i) entry.insert(entry.end(), sharing.others(i).size(), i);
  auto lists = pack(std::span(sharing_.rank), std::span<const std::size_t>(entry));
  neighbour_ = std::move(lists.rank);
  offset_ = std::move(lists.offset);
  entry_ = std::move(lists.items);
  Packets<GlobalId> ids{neighbour_, offset_, {}};
  ids.items.reserve(entry_.size());
  for (const std::size_t i : entry_) ids.items.push_back(sharing_.gid[i]);
  check_sharing(comm, ids);
}

void Halo::exchange_bytes(const void* in, void* out, std::size_t item) const {
  std::vector<detail::SendBlock> send;
  std::vector<detail::RecvBlock> recv;
  for (std::size_t n = 0; n < neighbour_.size(); ++n) {
    const std::size_t first = offset_[n] * item, bytes = (offset_[n + 1] - offset_[n]) * item;
    send.push_back({neighbour_[n], static_cast<const std::byte*>(in) + first, bytes});
    recv.push_back({neighbour_[n], static_cast<std::byte*>(out) + first, bytes});
  }
  detail::deliver(*comm_, send, recv);
}

}  // namespace skein
