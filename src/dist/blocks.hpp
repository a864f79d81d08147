// Who has an item of a list that the ranks have in consecutive blocks of any size.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"

namespace skein {

class Blocks {
 public:
  Blocks() = default;
  /// Collective. `first`: the number of this rank's first item.
  Blocks(const Comm& comm, std::int64_t first) : first_(comm.all_gather(first)) {}
  /// @pre the list has item i
  [[nodiscard]] Rank owner(std::int64_t i) const noexcept {
    return to_id<Rank>(std::upper_bound(first_.begin(), first_.end(), i) - first_.begin() - 1);
  }

 private:
  std::vector<std::int64_t> first_;  ///< by rank, ascending
};

}  // namespace skein
