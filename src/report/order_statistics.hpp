// Order statistics of numbers that lie on many ranks, without gathering them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"

namespace skein {

/// A rank's numbers in pieces, one for each of its threads.
using Pieces = std::span<const std::span<const double>>;

/// Collective. For each k the k-th smallest (from 0) of all ranks' values together, exact: the same bits for any number
/// of ranks and pieces. One histogram pass over the bits of the numbers for all, then three for each k over what is
/// near it; 512 kB of messages for each pass.
/// @pre values are not negative and not NaN; ks is the same on every rank; 0 <= k < the number of values on all ranks.
std::vector<double> order_statistics(const Comm& comm, Pieces values, std::span<const std::int64_t> ks);

/// The index of the p-th percentile among n sorted values: floor(p/100 n), at most n - 1. @pre n > 0.
std::int64_t percentile_index(double p, std::int64_t n) noexcept;

}  // namespace skein
