// The recipe of the kernel: in which order the passes make a part fit its metric.
#pragma once
#include "kernel/part.hpp"

namespace skein {

/// Makes the part fit its metric where vertices are kActive: removes short edges, creates points along long ones,
/// swaps, smooths, and improves the worst elements until none gets better. @pre prepare(part) has been called.
/// Interface faces (no neighbour, no kHullFace) and kFrozen vertices stay as they are.
/// Renumbers the part; returns old vertex -> new vertex (kNoVert for those that are gone).
IdVector<VertId, VertId> adapt_part(Part& part);

/// The first of two steps in which points are created, along edges longer than Lengths::first_step split_above; with
/// it, adapt_part finds that step done. Two steps of halves find better places than one in which long edges are split
/// beside short ones; and between the two, an interface may be refined that has been refined for the first one.
/// Conditions and result as adapt_part.
IdVector<VertId, VertId> create_coarse_points(Part& part);

}  // namespace skein
