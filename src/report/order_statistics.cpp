// Order statistics: radix selection; numbers that are not negative are ordered as their bit patterns are.
#include "report/order_statistics.hpp"

#include <algorithm>
#include <bit>

#include "base/parallel.hpp"

namespace skein {
namespace {

constexpr int kDigitBits = 16;
constexpr int kTopShift = 64 - kDigitBits;
constexpr std::size_t kBins = std::size_t{1} << kDigitBits;
using Bins = std::vector<std::int64_t>;

std::uint64_t bits_of(double v) noexcept { return std::bit_cast<std::uint64_t>(v + 0.0); }  // -0 becomes +0
std::size_t digit_of(std::uint64_t bits, int shift) noexcept { return (bits >> shift) & (kBins - 1); }

/// The digit of the k-th smallest; k becomes its place among those with this digit.
std::size_t find_digit(const Bins& bins, std::int64_t& k) noexcept {
  std::size_t digit = 0;
  while (digit + 1 < kBins && k >= bins[digit]) k -= bins[digit++];
  return digit;
}

/// Collective. How many values have each highest digit, over all ranks.
Bins count_top_digits(const Comm& comm, Pieces values) {
  std::vector<Bins> of_piece(values.size());
  in_parallel(static_cast<int>(values.size()), [&](int w) {
    const auto i = static_cast<std::size_t>(w);
    of_piece[i].assign(kBins, 0);
    for (const double v : values[i]) ++of_piece[i][digit_of(bits_of(v), kTopShift)];
  });
  Bins bins(kBins, 0);
  for (const Bins& piece : of_piece) {
    for (std::size_t b = 0; b < kBins; ++b) bins[b] += piece[b];
  }
  comm.reduce(std::span<std::int64_t>(bins), Op::kSum);
  return bins;
}

/// The bits of the values with this highest digit.
std::vector<std::uint64_t> with_top_digit(Pieces values, std::size_t digit) {
  std::vector<std::vector<std::uint64_t>> of_piece(values.size());
  in_parallel(static_cast<int>(values.size()), [&](int w) {
    const auto i = static_cast<std::size_t>(w);
    for (const double v : values[i]) {
      if (digit_of(bits_of(v), kTopShift) == digit) of_piece[i].push_back(bits_of(v));
    }
  });
  std::vector<std::uint64_t> out;
  for (const auto& piece : of_piece) out.insert(out.end(), piece.begin(), piece.end());
  return out;
}

double select(const Comm& comm, Pieces values, const Bins& top, std::int64_t k) {
  std::size_t digit = find_digit(top, k);
  auto found = static_cast<std::uint64_t>(digit) << kTopShift;
  std::vector<std::uint64_t> left = with_top_digit(values, digit);  // agree with the digits found so far
  Bins bins(kBins);
  for (int shift = kTopShift - kDigitBits; shift >= 0; shift -= kDigitBits) {
    std::fill(bins.begin(), bins.end(), 0);
    for (const std::uint64_t b : left) ++bins[digit_of(b, shift)];
    comm.reduce(std::span<std::int64_t>(bins), Op::kSum);
    digit = find_digit(bins, k);
    found |= static_cast<std::uint64_t>(digit) << shift;
    std::erase_if(left, [&](std::uint64_t b) { return digit_of(b, shift) != digit; });
  }
  return std::bit_cast<double>(found);
}

}  // namespace

std::vector<double> order_statistics(const Comm& comm, Pieces values, std::span<const std::int64_t> ks) {
  const Bins top = count_top_digits(comm, values);
  std::vector<double> result;
  for (const std::int64_t k : ks) result.push_back(select(comm, values, top, k));
  return result;
}

std::int64_t percentile_index(double p, std::int64_t n) noexcept {
  return std::min(n - 1, static_cast<std::int64_t>(p / 100 * static_cast<double>(n)));
}

}  // namespace skein
