// Distribution by digits.
#include "base/radix_sort.hpp"

#include <utility>

namespace skein {

void radix_sort(std::vector<KeyIndex>& items) {
  constexpr int kBits = 11, kPasses = 6;
  constexpr std::size_t kDigits = 1u << kBits;
  std::vector<KeyIndex> other(items.size());
  std::vector<std::size_t> count(kDigits);
  for (int pass = 0; pass < kPasses; ++pass) {
    const int shift = pass * kBits;
    const auto digit = [shift](std::uint64_t key) { return static_cast<std::size_t>(key >> shift) & (kDigits - 1); };
    count.assign(kDigits, 0);
    for (const auto& i : items) ++count[digit(i.key)];
    if (items.empty() || count[digit(items[0].key)] == items.size()) continue;
    std::size_t sum = 0;
    for (auto& c : count) sum += std::exchange(c, sum);
    for (const auto& i : items) other[count[digit(i.key)]++] = i;
    items.swap(other);
  }
}

}  // namespace skein
