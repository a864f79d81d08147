// Parts of a small graph by recursive bisection.
#pragma once
#include <cstdint>

#include "partition/graph.hpp"

namespace skein {

/// The part, in [0, parts), of each node: the graph is cut in two, and the pieces again, each time over coarser and
/// coarser graphs; on the coarsest, a part grows from several places and the best start is kept. No part heavier than
/// `capacity` where that can be. Parts are empty when there are more parts than nodes. Another seed gives another
/// cut, another number of threads the same. @pre graph has no ghosts.
IdVector<NodeId, PartId> bisect_recursively(const Graph& graph, int parts, std::int64_t capacity, std::uint64_t seed,
                                            int threads = 1);

}  // namespace skein
