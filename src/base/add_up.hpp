// Adding up what is listed more than once.
#pragma once
#include <algorithm>
#include <vector>

namespace skein {

/// Sorts by key(item); of items with equal keys one stays, with the sum of their counts (the member `count`).
template <class T, class Key, class Count>
void add_up(std::vector<T>& items, Key key, Count T::*count) {
  std::sort(items.begin(), items.end(), [&](const T& a, const T& b) { return key(a) < key(b); });
  std::size_t n = 0;
  for (const T& i : items) {
    if (n > 0 && key(items[n - 1]) == key(i)) {
      items[n - 1].*count += i.*count;
    } else {
      items[n++] = i;
    }
  }
  items.resize(n);
}

}  // namespace skein
