// Two threads write one number: with ThreadSanitizer this program must be reported, or the other tests prove nothing.
#include <cstdio>

#include "base/parallel.hpp"

int main() {
  int count = 0;
  skein::in_parallel(2, [&](int w) {
    for (int i = 0; i < 1000; ++i) count += w + i;
  });
  std::printf("%d\n", count);
}
