// Refinement of parts that lie on several ranks.
#pragma once
#include <cstddef>
#include <cstdint>

#include "comm/comm.hpp"
#include "partition/graph.hpp"
#include "partition/multilevel_refine.hpp"

namespace skein {

/// Makes the passes of one level; `nodes` is the size of its graph. Searches from the whole boundary make the large
/// improvements; small local searches find what these miss. Either alone leaves cuts that are several per cent longer.
void refine_all(Refiner& refiner, std::size_t nodes);

enum class Refine { kBalanceOnly, kAll };

/// Collective. Balances the parts over all ranks and shortens the cut (kAll). Where two ranks touch, only one of them
/// moves nodes at a time. Every rank that knows a part may fill an equal share of the part's free capacity, so no part
/// gets heavier than `capacity`. `part`: one per own node. The node `stays` is never moved (kNoNode: none). Threads
/// look for the boundary; the result does not depend on them.
/// @pre part in [0, parts).
void refine_level(const Comm& comm, const DistGraph& graph, int parts, std::int64_t capacity,
                  IdVector<NodeId, PartId>& part, Refine what = Refine::kAll, int threads = 1, NodeId stays = kNoNode);

}  // namespace skein
