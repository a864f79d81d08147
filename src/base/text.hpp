// Small pieces of text for people: grouped numbers, bars.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace skein {

/// 1234567 -> "1,234,567".
std::string grouped(std::int64_t n);
/// A bar of at most `width` characters for a share of 0 to 1; a share above 0 shows at least one character.
std::string bar(double share, int width = 40);

/// How many letters must be put in, taken out or changed to make b of a.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace skein
