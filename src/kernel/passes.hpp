// The passes of the kernel over one part, and the recipe that makes a part fit its metric.
#pragma once
#include "kernel/part.hpp"

namespace skein {

/// Quality of elements beside a vertex that had to stay from which on they need no more work when it is free.
inline constexpr double kGoodQuality = 0.75;

/// Makes the part fit its metric where vertices are kActive: removes short edges, creates points along long ones,
/// swaps, smooths, and works on the worst elements until none gets better. @pre prepare(part) has been called.
/// Interface faces (no neighbour, no kHullFace) and kFrozen vertices stay as they are.
/// Renumbers the part; returns old vertex -> new vertex (kNoVert for those that are gone).
IdVector<VertId, VertId> adapt_part(Part& part);

/// Points are created along edges longer than so many times KernelOptions::split_above first, all over, and then along
/// the others: two steps of halves find better places than one in which long edges are split beside short ones.
inline constexpr double kCoarse = 2;
/// The first of these steps alone, which adapt_part then finds done: between the two, an interface may be refined that
/// has been refined for the first one. Conditions and result as there.
IdVector<VertId, VertId> create_coarse_points(Part& part);

}  // namespace skein
