// Partition along a space-filling curve: parts that are contiguous along it and have equal work.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.hpp"
#include "base/ids.hpp"
#include "comm/comm.hpp"

namespace skein {

/// Collective. The box round all ranks' points; a rank without points is fine.
Box global_box(const Comm& comm, std::span<const Vec3> points);

/// Collective. All ranks' keys, in ascending order, are cut into `parts` intervals of equal work. Result: the part in
/// [0, parts) of each key. The bounds are weighted quantiles, found by histograms of the keys that are refined by 4
/// bits at a time; keys are not sent. Equal keys get the same part; parts may be empty.
/// @pre keys.size() == work.size(); work >= 0, finite; keys < 2^63.
std::vector<PartId> cut_keys(const Comm& comm, std::span<const std::uint64_t> keys, std::span<const double> work,
                             int parts);

}  // namespace skein
