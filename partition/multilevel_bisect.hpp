// Parts of a small graph by recursive bisection.
#pragma once
#include <cstdint>

#include "partition/graph.hpp"

namespace skein {

/// The part, in [0, parts), of each node. The graph is cut in two, then each half again. Each cut is made by multilevel
/// bisection: on the coarsest graph one part grows from several starting nodes, and the best result is kept. No part is
/// heavier than `capacity` where that is possible. Some parts are empty when there are more parts than nodes. The cut
/// depends on the seed, not on the number of threads. @pre graph has no ghosts.
IdVector<NodeId, PartId> bisect_recursively(const Graph& graph, int parts, std::int64_t capacity, std::uint64_t seed,
                                            int threads = 1);

}  // namespace skein
