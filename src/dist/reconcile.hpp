// The check that the ranks' parts make one mesh.
#pragma once
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. Throws Error(kInternal) on all ranks, with a line that tells the first fault of the lowest rank that
/// finds one, unless: local adjacency is mutual; every interface face has exactly two copies with opposite orientation,
/// equal tags and bit-equal coordinates and data; every hull face has one copy; no vertex number is twice on a rank;
/// the sharing lists name exactly the copies there are, with equal corner and required flags; the global counts are
/// right. Cheap: one pass over the faces, one exchange each for outer faces, outer vertices and shared vertices.
/// Vertices with kNoGlobal are allowed where they are on no interface. Adjacency is looked at with `threads` threads.
void reconcile(const Comm& comm, const DistMesh& dist, int threads = 1);

}  // namespace skein
