// Refinement of parts that lie on several ranks.
#pragma once
#include <cstddef>
#include <cstdint>

#include "comm/comm.hpp"
#include "partition/graph.hpp"
#include "partition/multilevel_refine.hpp"

namespace skein {

/// The passes of one level, for a graph with so many nodes. Searches from the whole boundary find the long way down,
/// small ones from everywhere what those pass over; each alone leaves cuts that are several percent longer.
void refine_all(Refiner& refiner, std::size_t nodes);

enum class Refine { kBalanceOnly, kAll };

/// Collective. Balances and shortens (kAll) the cut of parts over all ranks. Where ranks touch, one of the two moves
/// nodes at a time; of a part's room every rank that knows the part has an equal share, so that no part gets heavier
/// than `capacity`. `part`: one per own node; the node `stays` is never moved (kNoNode: there is none). Threads look
/// for the boundary; the result does not depend on them.
/// @pre part in [0, parts).
void refine_level(const Comm& comm, const DistGraph& graph, int parts, std::int64_t capacity,
                  IdVector<NodeId, PartId>& part, Refine what = Refine::kAll, int threads = 1, NodeId stays = kNoNode);

}  // namespace skein
