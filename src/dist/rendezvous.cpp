// Global id map and radix sort for the rendezvous.
#include "dist/rendezvous.hpp"

#include <array>
#include <bit>

namespace skein {

namespace {
/// Entries of a direct table per expected id, at most: a hash table has 2.
constexpr std::size_t kDirectShare = 4;
}  // namespace

GidMap::GidMap(std::size_t expected, std::int64_t total)
    : direct_(total > 0 && static_cast<std::size_t>(total) <= kDirectShare * expected) {
  const std::size_t hashed = std::bit_ceil(std::max<std::size_t>(16, expected + expected / 2));
  table_.assign(direct_ ? static_cast<std::size_t>(total) : hashed, -1);
  gids_.reserve(expected);
}

VertId GidMap::put(std::size_t slot, GlobalId g) {
  table_[slot] = static_cast<std::int32_t>(gids_.size());
  gids_.push_back(g);
  return VertId{table_[slot]};
}

VertId GidMap::insert(GlobalId g) {
  if (direct_) {
    const auto s = static_cast<std::size_t>(num(g));
    return table_[s] < 0 ? put(s, g) : VertId{table_[s]};
  }
  if (3 * (gids_.size() + 1) > 2 * table_.size()) grow();
  const std::size_t mask = table_.size() - 1;
  for (std::size_t s = mix(g) & mask;; s = (s + 1) & mask) {
    if (table_[s] < 0) return put(s, g);
    if (gids_[table_[s]] == g) return VertId{table_[s]};
  }
}

VertId GidMap::find(GlobalId g) const noexcept {
  if (direct_) {
    const std::int32_t v = table_[num(g)];
    return v < 0 ? kNoVert : VertId{v};
  }
  const std::size_t mask = table_.size() - 1;
  for (std::size_t s = mix(g) & mask;; s = (s + 1) & mask) {
    if (table_[s] < 0) return kNoVert;
    if (gids_[table_[s]] == g) return VertId{table_[s]};
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
