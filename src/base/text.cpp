// Small pieces of text for people.
#include "base/text.hpp"

#include <fmt/core.h>

#include <cmath>

namespace skein {

std::string grouped(std::int64_t n) {
  const std::string digits = fmt::format("{}", n);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > (n < 0 ? 1U : 0U) && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string bar(double share, int width) {
  const int n = share > 0 ? std::max(1, static_cast<int>(std::lround(share * width))) : 0;
  return std::string(static_cast<std::size_t>(n), '#');
}

}  // namespace skein
