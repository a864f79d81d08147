// Global id map and radix sort for the rendezvous.
#include "partition/rendezvous.hpp"

#include <array>
#include <bit>

namespace skein {

GidMap::GidMap(std::size_t expected)
    : table_(std::bit_ceil(std::max<std::size_t>(16, expected + expected / 2)), std::int32_t{-1}) {
  gids_.reserve(expected);
}

VertId GidMap::insert(GlobalId g) {
  if (3 * (gids_.size() + 1) > 2 * table_.size()) grow();
  const std::size_t mask = table_.size() - 1;
  for (std::size_t s = mix(g) & mask;; s = (s + 1) & mask) {
    if (table_[s] < 0) {
      table_[s] = static_cast<std::int32_t>(gids_.size());
      gids_.push_back(g);
      return VertId{table_[s]};
    }
    if (gids_[static_cast<std::size_t>(table_[s])] == g) return VertId{table_[s]};
  }
}

VertId GidMap::find(GlobalId g) const noexcept {
  const std::size_t mask = table_.size() - 1;
  for (std::size_t s = mix(g) & mask;; s = (s + 1) & mask) {
    if (table_[s] < 0) return kNoVert;
    if (gids_[static_cast<std::size_t>(table_[s])] == g) return VertId{table_[s]};
  }
}

void GidMap::grow() {
  table_.assign(2 * table_.size(), -1);
  const std::size_t mask = table_.size() - 1;
  for (std::size_t i = 0; i < gids_.size(); ++i) {
    std::size_t s = mix(gids_[i]) & mask;
    while (table_[s] >= 0) s = (s + 1) & mask;
    table_[s] = static_cast<std::int32_t>(i);
  }
}

}  // namespace skein
