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

/// Collective. The part of each key when all ranks' keys, in ascending order, are cut into `parts` pieces of equal
/// work: weighted quantiles by refining histograms on the keys, 4 bits at a time; no rank sees another's keys. Equal
/// keys are never separated; parts may be empty. Result: one part in [0, parts) for each key.
/// @pre keys.size() == work.size(); work >= 0, finite; keys < 2^63.
std::vector<PartId> cut_keys(const Comm& comm, std::span<const std::uint64_t> keys, std::span<const double> work,
                             int parts);

}  // namespace skein
