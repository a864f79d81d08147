// Connected parts: pieces that are not connected with the rest of their part go to a neighbouring part.
#pragma once
#include <cstdint>

#include "comm/comm.hpp"
#include "partition/graph.hpp"

namespace skein {

/// Collective. The heaviest connected piece of each part stays. Every other piece that is not heavier than `max_piece`
/// goes to the neighbouring part with the largest weight of common edges that stays within `capacity`. It stays if no
/// neighbour has room. Returns the number of pieces that had no room. A piece without any neighbour is not counted.
/// `part`: one per own node. @pre part in [0, parts).
std::size_t join_pieces(const Comm& comm, const DistGraph& graph, int parts, std::int64_t capacity,
                        std::int64_t max_piece, IdVector<NodeId, PartId>& part);

}  // namespace skein
