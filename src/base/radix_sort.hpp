// Sorting by 64-bit keys.
#pragma once
#include <cstdint>
#include <vector>

namespace skein {

/// A key and the place of its item.
struct KeyIndex {
  std::uint64_t key = 0;
  std::uint32_t index = 0;
};
/// Sorts by key, stable (least significant digit first; digits that all items share cost nothing but one count).
void radix_sort(std::vector<KeyIndex>& items);

}  // namespace skein
