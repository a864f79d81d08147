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
  explicit UnionFind(std::size_t n) : parent_(n) {
    for (std::size_t i = 0; i < n; ++i) parent_[to_id<Id>(i)] = to_id<Id>(i);
  }
  [[nodiscard]] Id root(Id i) noexcept {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Id i, Id j) noexcept {
    i = root(i);
    j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  IdVector<Id, Id> parent_;
};

}  // namespace skein
