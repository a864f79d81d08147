// The passes of the kernel over one part, and the recipe that makes a part fit its metric.
#pragma once
#include "kernel/part.hpp"

namespace skein {

/// Makes the part fit its metric where vertices are kActive: removes short edges, creates points along long ones,
/// swaps, smooths, and works on the worst elements until none gets better. @pre prepare(part) has been called.
/// Interface faces (no neighbour, no kHullFace) and kFrozen vertices stay as they are.
/// Renumbers the part; returns old vertex -> new vertex (kNoVert for those that are gone).
IdVector<VertId, VertId> adapt_part(Part& part);

}  // namespace skein
