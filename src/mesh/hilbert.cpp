// Hilbert curve keys by Skilling's transposed bit operations.
#include "mesh/hilbert.hpp"

#include <algorithm>
#include <array>

namespace skein {
namespace {

constexpr int kBits = 21;

std::uint32_t cell(double x, double low, double high) noexcept {
  if (!(high > low)) return 0;
  const double s = (x - low) / (high - low) * static_cast<double>(1u << kBits);
  return static_cast<std::uint32_t>(std::clamp(s, 0.0, static_cast<double>((1u << kBits) - 1)));
}

/// Spreads the low 21 bits so that two zero bits follow each.
std::uint64_t spread(std::uint64_t v) noexcept {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  v = (v | v << 2) & 0x1249249249249249ULL;
  return v;
}

}  // namespace

std::uint64_t hilbert_key(Vec3 x, const Box& box) noexcept {
  std::array<std::uint32_t, 3> a{cell(x.x, box.low.x, box.high.x), cell(x.y, box.low.y, box.high.y),
                                 cell(x.z, box.low.z, box.high.z)};
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    const std::uint32_t p = q - 1;
    for (auto& ai : a) {
      // Without a branch, since no processor could predict it: invert the low bits of a[0], or exchange them with ai's.
      const std::uint32_t invert = (ai & q) != 0 ? p : 0;
      const std::uint32_t t = (a[0] ^ ai) & p & ~invert;
      a[0] ^= t | invert;
      ai ^= t;
    }
  }
  a[1] ^= a[0];
  a[2] ^= a[1];
  std::uint32_t t = 0;
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    t ^= (a[2] & q) != 0 ? q - 1 : 0;
  }
  for (auto& ai : a) ai ^= t;
  return spread(a[0]) << 2 | spread(a[1]) << 1 | spread(a[2]);
}

}  // namespace skein
