// Refinement of a part's interface by a rule that both sides follow without talking to each other.
#pragma once
#include "kernel/part.hpp"

namespace skein {

/// Vertices between which refine_interface() keeps edges: those with one of these flags.
struct KeptVerts {
  VertClass of_class{};
  VertState of_state{};
  [[nodiscard]] bool has(const TetMesh& m, VertId v) const noexcept { return m.has(v, of_class) || m.has(v, of_state); }
};

/// Splits every interface edge longer than `times` KernelOptions::split_above at its middle, longest first, until there
/// is none: edges of faces that have no neighbour and are not on the hull. A coarse frozen interface inside a much
/// finer mesh would spoil the elements round it. The order (metric length, then global ids) is total, and what happens
/// to one interface face depends only on its own edges; so the parts on both sides, having the same bits, make the same
/// triangles and the same points. A new vertex gets kFrozen and a global id that is a hash of its edge's two ids, the
/// same in every part.
///
/// Edges with both ends in `keep` stay as they are, those with one are split a few times at most. False when a
/// tetrahedron would be inverted by rounding: the part is then of no use, and the caller goes back to a copy (on all
/// sides). @pre prepare(part); gid has one id per vertex.
bool refine_interface(Part& part, IdVector<VertId, GlobalId>& gid, KeptVerts keep = {}, double times = 1);

}  // namespace skein
