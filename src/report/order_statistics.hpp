// Order statistics of numbers that lie on many ranks, without gathering them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"

namespace skein {

/// A rank's numbers in pieces, one for each of its threads.
using Pieces = std::span<const std::span<const double>>;

/// Collective. For each k the k-th smallest value (from 0) over all ranks, exact: the same bits for any number of ranks
/// and pieces. One pass makes a histogram of the leading bits of all values; three more passes for each k refine it
/// near that value. Each pass sends 512 kB.
/// @pre values are not negative and not NaN; ks is the same on every rank; 0 <= k < the number of values on all ranks.
std::vector<double> order_statistics(const Comm& comm, Pieces values, std::span<const std::int64_t> ks);

/// The index of the p-th percentile among n sorted values: floor(p/100 n), at most n - 1. @pre n > 0.
std::int64_t percentile_index(double p, std::int64_t n) noexcept;

}  // namespace skein
