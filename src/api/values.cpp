#include "api/values.hpp"

#include <algorithm>

namespace skein {

std::vector<double> side_by_side(const std::vector<double>& a, int width_a, const std::vector<double>& b, int width_b) {
  const auto wa = static_cast<std::size_t>(width_a), wb = static_cast<std::size_t>(width_b);
  std::vector<double> out(a.size() + b.size());
  for (std::size_t i = 0; i * (wa + wb) < out.size(); ++i) {
    std::copy_n(a.data() + i * wa, wa, out.data() + i * (wa + wb));
    std::copy_n(b.data() + i * wb, wb, out.data() + i * (wa + wb) + wa);
  }
  return out;
}

std::vector<double> columns(const std::vector<double>& values, int width, int first, int n) {
  const auto w = static_cast<std::size_t>(width), k = static_cast<std::size_t>(n);
  std::vector<double> out;
  if (k == 0) return out;
  out.reserve(values.size() / w * k);
  for (std::size_t i = static_cast<std::size_t>(first); i < values.size(); i += w) {
    out.insert(out.end(), values.data() + i, values.data() + i + k);
  }
  return out;
}

}  // namespace skein
