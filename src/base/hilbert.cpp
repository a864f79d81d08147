// Hilbert curve keys by Skilling's transposed bit operations.
#include "base/hilbert.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/loops.hpp"

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

namespace {

/// Points at a time, so that the compiler can use the vector unit: the loops over bits have no branches.
constexpr std::size_t kLanes = 16;
using Lanes = std::array<std::uint32_t, kLanes>;

void transpose(Lanes& x, Lanes& y, Lanes& z) noexcept {
  // Inverts the low bits p of x where a has the bit q, else exchanges them with a's.
  const auto turn = [](std::uint32_t& first, std::uint32_t& a, std::uint32_t q, std::uint32_t p) {
    const std::uint32_t invert = (a & q) != 0 ? p : 0, exchange = (first ^ a) & p & ~invert;
    first ^= exchange | invert;
    a ^= exchange;
  };
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    const std::uint32_t p = q - 1;
    SKEIN_INDEPENDENT_LOOP
    for (std::size_t l = 0; l < kLanes; ++l) {
      x[l] ^= (x[l] & q) != 0 ? p : 0;
      turn(x[l], y[l], q, p);
      turn(x[l], z[l], q, p);
    }
  }
  SKEIN_INDEPENDENT_LOOP
  for (std::size_t l = 0; l < kLanes; ++l) {
    y[l] ^= x[l];
    z[l] ^= y[l];
    std::uint32_t t = z[l];  // bit b of the flip is the parity of the bits above b
    t ^= t >> 1, t ^= t >> 2, t ^= t >> 4, t ^= t >> 8, t ^= t >> 16;
    t >>= 1;
    x[l] ^= t;
    y[l] ^= t;
    z[l] ^= t;
  }
}

}  // namespace

void hilbert_keys(std::span<const Vec3> x, const Box& box, std::span<std::uint64_t> key) noexcept {
  Lanes a, b, c;
  for (std::size_t begin = 0; begin < x.size(); begin += kLanes) {
    const std::size_t n = std::min(kLanes, x.size() - begin);
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Vec3 at = x[begin + std::min(l, n - 1)];
      a[l] = cell(at.x, box.low.x, box.high.x);
      b[l] = cell(at.y, box.low.y, box.high.y);
      c[l] = cell(at.z, box.low.z, box.high.z);
    }
    transpose(a, b, c);
    for (std::size_t l = 0; l < n; ++l) key[begin + l] = spread(a[l]) << 2 | spread(b[l]) << 1 | spread(c[l]);
  }
}

std::uint64_t hilbert_key(Vec3 x, const Box& box) noexcept {
  std::uint64_t key = 0;
  hilbert_keys({&x, 1}, box, {&key, 1});
  return key;
}

}  // namespace skein
