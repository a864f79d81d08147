// Sets of flags as types of their own: an enum class whose values are bits, so that flags of two kinds cannot be mixed.
#pragma once
#include <type_traits>

namespace skein {

/// Specialise this for an enum class whose values are bits of a set; E{} is the empty set.
template <class E>
inline constexpr bool kIsFlagSet = false;
template <class E>
concept FlagSet = kIsFlagSet<E>;

template <FlagSet E>
constexpr E operator|(E a, E b) noexcept {
  using Bits = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<Bits>(static_cast<Bits>(a) | static_cast<Bits>(b)));
}
template <FlagSet E>
constexpr E operator&(E a, E b) noexcept {
  using Bits = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<Bits>(static_cast<Bits>(a) & static_cast<Bits>(b)));
}
template <FlagSet E>
constexpr E operator~(E a) noexcept {
  using Bits = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<Bits>(~static_cast<Bits>(a)));
}
template <FlagSet E>
constexpr E& operator|=(E& a, E b) noexcept {
  return a = a | b;
}
template <FlagSet E>
constexpr E& operator&=(E& a, E b) noexcept {
  return a = a & b;
}
/// The set is not empty.
template <FlagSet E>
constexpr bool any(E set) noexcept {
  return set != E{};
}

}  // namespace skein
