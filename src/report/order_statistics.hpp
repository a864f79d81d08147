// Order statistics of numbers that lie on many ranks, without gathering them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "comm/comm.hpp"

namespace skein {

/// Collective. For each k the k-th smallest (from 0) of all ranks' values together, exact: the same bits for any number
/// of ranks. Four histogram passes over the bits of the numbers; 512 kB of messages for each k and pass.
/// @pre values are not negative and not NaN; ks is the same on every rank; 0 <= k < the number of values on all ranks.
std::vector<double> order_statistics(const Comm& comm, std::span<const double> values,
                                     std::span<const std::int64_t> ks);

/// The index of the p-th percentile among n sorted values: floor(p/100 n), at most n - 1. @pre n > 0.
std::int64_t percentile_index(double p, std::int64_t n) noexcept;

}  // namespace skein
