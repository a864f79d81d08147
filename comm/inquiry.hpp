// Questions to other ranks, and their answers: two sparse exchanges.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "comm/exchange.hpp"

namespace skein {

/// Collective. exchange() of vectors.
template <Sendable T>
Packets<T> exchange_items(const Comm& comm, const std::vector<Rank>& dest, const std::vector<T>& items) {
  return exchange(comm, std::span<const Rank>(dest), std::span<const T>(items));
}

/// Questions to other ranks; answers come back in the order of the questions.
template <Sendable Q>
class Inquiry {
 public:
  /// Collective. Sends each question to its rank.
  Inquiry(const Comm& comm, const std::vector<Rank>& dest, const std::vector<Q>& questions) : comm_(&comm) {
    std::vector<std::uint32_t> place(questions.size());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<std::uint32_t>(i);
    sent_ = pack(std::span<const Rank>(dest), std::span<const Q>(questions));
    order_ = pack(std::span<const Rank>(dest), std::span<const std::uint32_t>(place)).items;
    asked_ = exchange(comm, sent_);
  }
  /// The questions to this rank, in blocks by source rank.
  [[nodiscard]] const Packets<Q>& asked() const noexcept { return asked_; }
  /// Collective. answers: `width` values for each of asked().items. Gives `width` values per question.
  template <Sendable A>
  [[nodiscard]] std::vector<A> answer(const std::vector<A>& answers, std::size_t width = 1) const {
    Packets<A> back;
    back.rank = asked_.rank;
    back.offset = asked_.offset;
    for (auto& o : back.offset) o *= width;
    back.items = answers;
    const Packets<A> got = exchange(*comm_, back);
    std::vector<A> out(order_.size() * width);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      for (std::size_t c = 0; c < width; ++c) out[order_[i] * width + c] = got.items[i * width + c];
    }
    return out;
  }

 private:
  const Comm* comm_;
  Packets<Q> sent_, asked_;
  std::vector<std::uint32_t> order_;
};

}  // namespace skein
