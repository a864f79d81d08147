// A few of many identifiers, numbered.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/ids.hpp"

namespace skein {

/// A set of identifiers below n whose members have places: 0, 1, ... in ascending order. It takes two bits per
/// identifier, where a table of places would take more memory than the few members themselves.
template <Identifier Id>
class Subset {
 public:
  explicit Subset(std::size_t n) : words_(n / kBits + 1) {}

  void insert(Id i) noexcept { words_[idx(i) / kBits].member |= std::uint64_t{1} << idx(i) % kBits; }
  /// Gives the members their places, after the last insert().
  void number() noexcept {
    size_ = 0;
    for (Word& w : words_) {
      w.before = size_;
      size_ += static_cast<std::size_t>(std::popcount(w.member));
    }
  }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool has(Id i) const noexcept { return (words_[idx(i) / kBits].member >> idx(i) % kBits & 1) != 0; }
  /// @pre has(i), number()
  [[nodiscard]] std::size_t place(Id i) const noexcept {
    const Word& w = words_[idx(i) / kBits];
    const std::uint64_t below = w.member & ((std::uint64_t{1} << idx(i) % kBits) - 1);
    return w.before + static_cast<std::size_t>(std::popcount(below));
  }
  /// Ascending. @pre number()
  [[nodiscard]] std::vector<Id> members() const {
    std::vector<Id> out;
    out.reserve(size_);
    for (std::size_t k = 0; k < words_.size(); ++k) {
      for (std::uint64_t w = words_[k].member; w != 0; w &= w - 1)
        out.push_back(to_id<Id>(k * kBits + static_cast<std::size_t>(std::countr_zero(w))));
    }
    return out;
  }

 private:
  static constexpr std::size_t kBits = 64;
  struct Word {
    std::uint64_t member = 0;
    std::size_t before = 0;
  };
  std::vector<Word> words_;
  std::size_t size_ = 0;
};

/// Different ids below n, put in order.
template <Identifier Id>
std::vector<Id> ascending(const std::vector<Id>& ids, std::size_t n) {
  Subset<Id> set(n);
  for (const Id i : ids) set.insert(i);
  set.number();
  return set.members();
}

}  // namespace skein
