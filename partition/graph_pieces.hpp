// Connected parts: pieces of a part that have lost touch with the rest of it go to a neighbour.
#pragma once
#include <cstdint>

#include "comm/comm.hpp"
#include "partition/graph.hpp"

namespace skein {

/// Collective. Of each part over all ranks, the heaviest connected piece stays; every other one no heavier than
/// `max_piece` goes to the neighbouring part with the most contact that stays within `capacity`; a piece for which no
/// neighbour has room stays. Returns how many of those there are; a body of its own, without a neighbour, is none.
/// `part`: one per own node. @pre part in [0, parts).
std::size_t join_pieces(const Comm& comm, const DistGraph& graph, int parts, std::int64_t capacity,
                        std::int64_t max_piece, IdVector<NodeId, PartId>& part);

}  // namespace skein
