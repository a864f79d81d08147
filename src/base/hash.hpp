// Mixing of bits for hash tables, rendezvous and pseudo-random choices.
#pragma once
#include <cstdint>

namespace skein {

/// Well-mixed bits of a number (finaliser of SplitMix64, S. Vigna).
constexpr std::uint64_t mix(std::uint64_t x) noexcept {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

}  // namespace skein
