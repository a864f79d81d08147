// Sparse exchange: every rank sends blocks of items to a few other ranks and receives blocks, sorted by source rank.
#pragma once
#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "comm/comm.hpp"

namespace skein {

/// Items in blocks, one block per rank. rank is strictly ascending; block i is items[offset[i] .. offset[i+1]).
template <Sendable T>
struct Packets {
  std::vector<Rank> rank;
  std::vector<std::size_t> offset{0};
  std::vector<T> items;

  [[nodiscard]] std::size_t blocks() const noexcept { return rank.size(); }
  [[nodiscard]] std::span<const T> block(std::size_t i) const noexcept {
    return {items.data() + offset[i], offset[i + 1] - offset[i]};
  }
};

/// Items and their destinations as packets; stable within a destination. @pre dest.size() == items.size().
template <Sendable T>
Packets<T> pack(std::span<const Rank> dest, std::span<const T> items);

/// The same for items that the caller no longer needs: they are not copied when all go to one rank.
template <Sendable T>
Packets<T> pack(std::span<const Rank> dest, std::vector<T>&& items);

/// Collective. Delivers each block to its rank (also to oneself). Blocks come sorted by source rank; no empty block.
template <Sendable T>
Packets<T> exchange(const Comm& comm, const Packets<T>& send);

/// Collective. The same for packets that the caller no longer needs: not copied on a single rank, freed early on many.
template <Sendable T>
Packets<T> exchange(const Comm& comm, Packets<T>&& send);

/// Collective. exchange(pack(dest, items)).
template <Sendable T>
Packets<T> exchange(const Comm& comm, std::span<const Rank> dest, std::span<const T> items) {
  return exchange(comm, pack(dest, items));
}

/// Collective. Sends one answer back for each item of `asked` (what exchange gave), in the same order; the result has
/// one answer for each item that this rank had sent with `sent`, in that order. @pre answers.size() ==
/// asked.items.size().
template <Sendable Q, Sendable A>
std::vector<A> reply(const Comm& comm, const Packets<Q>& sent, const Packets<Q>& asked, std::span<const A> answers);

}  // namespace skein

#include "comm/exchange_inl.hpp"
