// Disjoint sets.
#pragma once
#include <algorithm>
#include <cstddef>

#include "base/ids.hpp"

namespace skein {

/// Sets of identifiers below n that are joined over time; the root of a set is its smallest member.
template <Identifier Id>
class UnionFind {
 public:
  explicit UnionFind(std::size_t n) { reset(n); }
  /// All n apart again.
  void reset(std::size_t n) {
    parent_.resize(n);
    for (const Id i : IdRange<Id>(n)) parent_[i] = i;
  }
  [[nodiscard]] Id root(Id i) noexcept {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// False when they are together already.
  bool join(Id i, Id j) noexcept {
    i = root(i);
    j = root(j);
    if (i == j) return false;
    parent_[std::max(i, j)] = std::min(i, j);
    return true;
  }

 private:
  IdVector<Id, Id> parent_;
};

}  // namespace skein
