// The faces between ranks, each with its copy on the other rank.
#pragma once
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// A face of this rank and the same face on another rank.
struct InterfaceFace {
  FaceId mine = kNoFace;
  Rank rank{-1};
  FaceId theirs = kNoFace;
};

/// Collective. All local faces that have no local neighbour and no kHullFace, ascending by `mine`. Throws
/// Error(kInternal) on all ranks when one has not exactly one copy elsewhere.
std::vector<InterfaceFace> match_interface(const Comm& comm, const DistMesh& dist);

/// Collective. What the other side of each interface face says: value[i] is sent to the owner of faces[i].theirs;
/// the result's entry i comes from there.
template <Sendable T>
std::vector<T> swap_over_interface(const Comm& comm, const std::vector<InterfaceFace>& faces,
                                   const std::vector<T>& value);

}  // namespace skein

#include "dist/interface_faces_inl.hpp"
