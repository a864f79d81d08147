// Multilevel partition of a graph over all ranks: short interfaces at a bounded imbalance.
#pragma once
#include "comm/comm.hpp"
#include "partition/graph.hpp"

namespace skein {

struct MultilevelOptions {
  double imbalance = 0.03;  ///< a part may have this much more than the mean work, or the heaviest node more
  int threads = 1;          ///< in each rank: graphs are made and made coarser, and first cuts tried, by as many
};

/// Collective. The part, in [0, parts), of each of this rank's nodes. Every rank makes its graph coarser by pairs
/// inside the rank; the coarse graphs together, of bounded size, are on every rank, which cuts them with a seed of its
/// own; the best cut of all ranks is carried back to the nodes and improved on each level, in turns where ranks meet.
/// Pieces that are cut off from the rest of their part go to a neighbour, which passes on what it has too much by that,
/// until all parts are connected or ten attempts have found nothing better. Parts are empty when there are more of them
/// than nodes. Deterministic for the same distribution and threads. (Heavy-edge coarsening and k-way refinement:
/// G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20, 1998; local search with rollback: C. Fiduccia, R. Mattheyses, 1982.)
/// @pre node weights as set_weights() gives them; parts >= 1.
IdVector<NodeId, PartId> multilevel_partition(const Comm& comm, DistGraph graph, int parts,
                                              const MultilevelOptions& options = {});

}  // namespace skein
