// The layout of numbers in a GMF binary file, by version and byte order.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace skein::io {

inline constexpr std::int32_t kGmfNative = 1;          ///< first number of a file in this machine's byte order
inline constexpr std::int32_t kGmfSwapped = 16777216;  ///< the same in the other byte order

/// Bytes of a whole number, a real number and a position in a file of this version.
constexpr std::int64_t gmf_int_bytes(int version) noexcept { return version >= 4 ? 8 : 4; }
constexpr std::int64_t gmf_real_bytes(int version) noexcept { return version == 1 ? 4 : 8; }
constexpr std::int64_t gmf_position_bytes(int version) noexcept { return version >= 3 ? 8 : 4; }

template <class T, bool Swap>
T gmf_load(const std::byte* p) noexcept {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  Bits b;
  std::memcpy(&b, p, sizeof b);
  if constexpr (Swap) {
    if constexpr (sizeof(T) == 4) {
      b = __builtin_bswap32(b);
    } else {
      b = __builtin_bswap64(b);
    }
  }
  T v;
  std::memcpy(&v, &b, sizeof v);
  return v;
}
template <class T>
void gmf_store(std::byte* p, T v) noexcept {
  std::memcpy(p, &v, sizeof v);
}

/// The number types of a file at compile time, for the decoding loops.
template <class I, class R, bool S>
struct GmfLayout {
  using Int = I;
  using Real = R;
  static constexpr bool kSwap = S;
};

/// Of a file, as this machine sees it.
enum class ByteOrder { kNative, kSwapped };

/// Calls f with the GmfLayout of the version and byte order. @pre 1 <= version <= 4.
template <class F>
void with_gmf_layout(int version, ByteOrder order, F&& f) {
  const auto by_order = [&]<class I, class R>(I, R) {
    order == ByteOrder::kSwapped ? f(GmfLayout<I, R, true>{}) : f(GmfLayout<I, R, false>{});
  };
  if (version == 1) return by_order(std::int32_t{}, float{});
  if (version <= 3) return by_order(std::int32_t{}, double{});
  by_order(std::int64_t{}, double{});
}

}  // namespace skein::io
