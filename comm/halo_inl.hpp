// Templates of halo.hpp.
#pragma once
#include "comm/halo.hpp"

namespace skein {

namespace detail {

/// A few numbers; the call of a library function for one would take most of the time.
template <class T>
void copy_few(const T* from, std::size_t n, T* to) noexcept {
  for (std::size_t c = 0; c < n; ++c) to[c] = from[c];
}

}  // namespace detail

template <Reducible T, class At, class Fold>
void Halo::fold_copies(At at, int width, Fold fold) const {
  const auto w = static_cast<std::size_t>(width);
  std::vector<T> mine(entry_.size() * w), theirs(entry_.size() * w);
  for (std::size_t k = 0; k < entry_.size(); ++k) detail::copy_few(at(entry_[k]), w, mine.data() + k * w);
  exchange_bytes(mine.data(), theirs.data(), w * sizeof(T));

  // Ascending ranks, this one at its place; the first copy starts the value.
  std::vector<T> total(sharing_.size() * w);
  std::vector<std::uint8_t> started(sharing_.size(), 0);
  const auto take = [&](std::size_t i, const T* copy) {
    T* t = total.data() + i * w;
    if (started[i] == 0) {
      detail::copy_few(copy, w, t);
      started[i] = 1;
    } else {
      for (std::size_t c = 0; c < w; ++c) t[c] = fold(t[c], copy[c]);
    }
  };
  std::size_t n = 0;
  const auto take_neighbour = [&] {
    for (std::size_t k = offset_[n]; k < offset_[n + 1]; ++k) take(entry_[k], theirs.data() + k * w);
  };
  for (; n < neighbour_.size() && neighbour_[n] < comm_->rank(); ++n) take_neighbour();
  for (std::size_t i = 0; i < sharing_.size(); ++i) take(i, at(i));
  for (; n < neighbour_.size(); ++n) take_neighbour();
  for (std::size_t i = 0; i < sharing_.size(); ++i) detail::copy_few(total.data() + i * w, w, at(i));
}

template <Reducible T, class At>
void Halo::combine(At at, int width, Op op) const {
  switch (op) {
    case Op::kSum:
      return fold_copies<T>(at, width, [](T a, T b) { return a + b; });
    case Op::kMin:
      return fold_copies<T>(at, width, [](T a, T b) { return b < a ? b : a; });
    case Op::kMax:
      return fold_copies<T>(at, width, [](T a, T b) { return a < b ? b : a; });
  }
}

template <Reducible T>
void Halo::copy_from_owner(std::span<T> values, int width) const {
  fold_copies<T>(at_vertex(values, width), width, [](T a, T) { return a; });
}

}  // namespace skein
