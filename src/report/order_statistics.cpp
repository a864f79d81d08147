// Order statistics: radix selection; numbers that are not negative are ordered as their bit patterns are.
#include "report/order_statistics.hpp"

#include <algorithm>
#include <bit>

namespace skein {
namespace {

constexpr int kDigitBits = 16;
constexpr std::size_t kBins = std::size_t{1} << kDigitBits;

double select(const Comm& comm, std::span<const double> values, std::int64_t k) {
  std::vector<std::uint64_t> left;  // candidates: those that agree with the digits found so far
  left.reserve(values.size());
  for (const double v : values) left.push_back(std::bit_cast<std::uint64_t>(v + 0.0));  // -0 becomes +0
  std::vector<std::int64_t> bins(kBins);
  std::uint64_t found = 0;
  for (int shift = 64 - kDigitBits; shift >= 0; shift -= kDigitBits) {
    std::fill(bins.begin(), bins.end(), 0);
    for (const std::uint64_t b : left) ++bins[(b >> shift) & (kBins - 1)];
    comm.reduce(std::span<std::int64_t>(bins), Op::kSum);
    std::size_t digit = 0;
    while (digit + 1 < kBins && k >= bins[digit]) k -= bins[digit++];
    found |= static_cast<std::uint64_t>(digit) << shift;
    std::erase_if(left, [&](std::uint64_t b) { return ((b >> shift) & (kBins - 1)) != digit; });
  }
  return std::bit_cast<double>(found);
}

}  // namespace

std::vector<double> order_statistics(const Comm& comm, std::span<const double> values,
                                     std::span<const std::int64_t> ks) {
  std::vector<double> result;
  for (const std::int64_t k : ks) result.push_back(select(comm, values, k));
  return result;
}

std::int64_t percentile_index(double p, std::int64_t n) noexcept {
  return std::min(n - 1, static_cast<std::int64_t>(p / 100 * static_cast<double>(n)));
}

}  // namespace skein
