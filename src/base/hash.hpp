// Mixing of bits for hash tables, rendezvous and pseudo-random choices.
#pragma once
#include <cstdint>

namespace skein {

inline constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15ULL;  ///< 2^64 over the golden ratio, odd

/// Well-mixed bits of a number that is not small (the last steps of [SplitMix64]; 0 stays 0).
constexpr std::uint64_t finalise(std::uint64_t x) noexcept {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}
/// Well-mixed bits of any number (SplitMix64).
constexpr std::uint64_t mix(std::uint64_t x) noexcept { return finalise(x + kGoldenRatio); }
/// Well-mixed bits of a pair; axis and level of a cell beside its key, for example. Small numbers suffice for b.
constexpr std::uint64_t mix_pair(std::uint64_t a, std::uint64_t b) noexcept {
  std::uint64_t h = a * kGoldenRatio + b * 0xd1b54a32d192ed03ULL;
  h = (h ^ h >> 32) * 0xd6e8feb86659fd93ULL;
  return (h ^ h >> 32) * 0xd6e8feb86659fd93ULL;
}
/// For tables in hot loops: one multiplication, the 44 bits of it that all bits of the key reach.
constexpr std::uint64_t table_hash(std::uint64_t key) noexcept { return (key ^ key >> 29) * kGoldenRatio >> 20; }
/// For sums over very many numbers: one multiplication.
constexpr std::uint64_t scramble(std::uint64_t x) noexcept {
  x *= kGoldenRatio;
  return x ^ (x >> 32);
}

}  // namespace skein
