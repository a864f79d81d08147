// The check that the ranks' parts make one mesh.
#pragma once
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. Checks that
///   - neighbours name each other;
///   - every interface face has exactly two copies, with opposite orientation, equal tags, and equal bits of
///     coordinates and data; every hull face has one copy;
///   - no global id is twice on a rank;
///   - the sharing lists name exactly the copies that exist, with equal corner and required flags;
///   - the global counts are right.
/// Otherwise throws Error(kInternal) on all ranks: the first fault on the lowest rank that finds one. Vertices with
/// kNoGlobal are allowed where they are on no interface. One pass over the faces with `threads` threads, and one
/// exchange each for outer faces, outer vertices and shared vertices.
void reconcile(const Comm& comm, const DistMesh& dist, int threads = 1);

}  // namespace skein
