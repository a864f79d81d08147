// Templates of exchange.hpp, brought down to blocks of bytes.
#pragma once
#include "comm/exchange.hpp"

namespace skein {
namespace detail {

/// A block on its way to or from `rank`.
struct SendBlock {
  Rank rank;
  const void* data;
  std::size_t bytes;
};
struct RecvBlock {
  Rank rank;
  void* data;
  std::size_t bytes;
};
/// Which rank sends how many bytes.
struct Announced {
  Rank rank;
  std::size_t bytes;
};

/// Collective. Tells the receivers what will come; the answer is sorted by rank and has no empty block.
std::vector<Announced> announce(const Comm& comm, std::span<const SendBlock> send);
/// Called by all ranks that send or receive (collective among these). Both sides know the sizes; empty blocks are left
/// out; one block at most per pair and direction.
void deliver(const Comm& comm, std::span<const SendBlock> send, std::span<const RecvBlock> recv);

template <Sendable T>
std::vector<SendBlock> send_blocks(std::span<const Rank> rank, std::span<const std::size_t> offset, const T* items) {
  std::vector<SendBlock> out;
  out.reserve(rank.size());
  for (std::size_t i = 0; i < rank.size(); ++i)
    out.push_back({rank[i], items + offset[i], (offset[i + 1] - offset[i]) * sizeof(T)});
  return out;
}
template <Sendable T>
std::vector<RecvBlock> recv_blocks(std::span<const Rank> rank, std::span<const std::size_t> offset, T* items) {
  std::vector<RecvBlock> out;
  out.reserve(rank.size());
  for (std::size_t i = 0; i < rank.size(); ++i)
    out.push_back({rank[i], items + offset[i], (offset[i + 1] - offset[i]) * sizeof(T)});
  return out;
}

}  // namespace detail

template <Sendable T>
Packets<T> pack(std::span<const Rank> dest, std::span<const T> items) {
  std::size_t ranks = 0;
  for (const Rank r : dest) ranks = std::max(ranks, idx(r) + 1);
  std::vector<std::size_t> next(ranks + 1, 0);
  for (const Rank r : dest) ++next[idx(r) + 1];
  Packets<T> out;
  for (std::size_t r = 0; r < ranks; ++r) {
    const std::size_t count = next[r + 1];
    next[r + 1] += next[r];
    if (count == 0) continue;
    out.rank.push_back(to_id<Rank>(r));
    out.offset.push_back(next[r + 1]);
  }
  out.items.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) out.items[next[idx(dest[i])]++] = items[i];
  return out;
}

template <Sendable T>
Packets<T> exchange(const Comm& comm, const Packets<T>& send) {
  const auto blocks = detail::send_blocks(std::span(send.rank), std::span(send.offset), send.items.data());
  Packets<T> out;
  for (const auto& a : detail::announce(comm, blocks)) {
    out.rank.push_back(a.rank);
    out.offset.push_back(out.offset.back() + a.bytes / sizeof(T));
  }
  out.items.resize(out.offset.back());
  detail::deliver(comm, blocks, detail::recv_blocks(std::span(out.rank), std::span(out.offset), out.items.data()));
  return out;
}

template <Sendable T>
Packets<T> pack(std::span<const Rank> dest, std::vector<T>&& items) {
  const bool one = std::adjacent_find(dest.begin(), dest.end(), std::not_equal_to<>()) == dest.end();
  if (!one || items.empty()) {
    Packets<T> out = pack(dest, std::span<const T>(items));
    items = {};
    return out;
  }
  Packets<T> out;
  out.rank.push_back(dest.front());
  out.offset.push_back(items.size());
  out.items = std::move(items);
  return out;
}

template <Sendable T>
Packets<T> exchange(const Comm& comm, Packets<T>&& send) {
  Packets<T> taken = std::move(send);
  if (comm.size() == 1) return taken.items.empty() ? Packets<T>{} : std::move(taken);
  return exchange(comm, std::as_const(taken));
}

template <Sendable Q, Sendable A>
std::vector<A> reply(const Comm& comm, const Packets<Q>& sent, const Packets<Q>& asked, std::span<const A> answers) {
  std::vector<A> out(sent.items.size());
  detail::deliver(comm, detail::send_blocks(std::span(asked.rank), std::span(asked.offset), answers.data()),
                  detail::recv_blocks(std::span(sent.rank), std::span(sent.offset), out.data()));
  return out;
}

}  // namespace skein
