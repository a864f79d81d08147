// Multilevel partition of a graph over all ranks: short interfaces at a bounded imbalance.
#pragma once
#include "comm/comm.hpp"
#include "partition/graph.hpp"

namespace skein {

struct MultilevelOptions {
  double imbalance = 0.03;  ///< a part's work may exceed the mean by this share, or by the heaviest node
  int threads = 1;          ///< in each rank, for making and coarsening graphs and for the first cuts
};

/// Collective. The part, in [0, parts), of each of this rank's nodes.
///   1. Every rank coarsens its graph by matching nodes inside the rank [KarypisKumar1998].
///   2. All ranks get the coarse graphs of all ranks, which have a bounded size. Each cuts them with a seed of its own,
///      and the best cut is taken.
///   3. The cut is carried back level by level and improved on each by local search [FiducciaMattheyses1982]; where
///      ranks meet, they take turns.
///   4. A piece that is not connected with the rest of its part goes to a neighbouring part, which passes its surplus
///      on, until all parts are connected or ten attempts have found nothing better.
/// Some parts are empty when there are more parts than nodes. Deterministic for the same distribution and threads.
/// @pre node weights as set_weights() gives them; parts >= 1.
IdVector<NodeId, PartId> multilevel_partition(const Comm& comm, DistGraph graph, int parts,
                                              const MultilevelOptions& options = {});

}  // namespace skein
