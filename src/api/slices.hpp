// The arrays of a caller as slices, and slices as arrays.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "skein/skein.hpp"

namespace skein {

/// Collective. Arrays become slices; each is freed when it has been read. Throws Error(kInvalidMesh) on all ranks for
/// references that are not as many as their entities, and for numbers out of range in the lists of corners and so on.
MeshSlice to_mesh_slice(const Comm& comm, SlicedMesh mesh);

/// Collective. The fields at the vertices, in the order of to_slices().
std::vector<double> field_slice(const Comm& comm, const DistMesh& dist);

/// The arrays of what to_slices() gives. Not collective.
SlicedMesh to_sliced_mesh(MeshSlice slice);

/// Numbers at the vertices of a caller: `width` per vertex, called `what` in messages. Throws Error(kInput) unless
/// there are as many as n vertices want. Not collective.
void require_values(const std::vector<double>& values, int width, std::size_t n, const std::string& what);

/// Throws Error(kInvalidMesh) unless there is a reference for each of n entities; none at all stand for zeros. Not
/// collective.
void complete_refs(std::vector<std::int32_t>& refs, std::size_t n, const char* entities);

/// Collective. Sets where this rank's entities begin, and how many there are.
template <class List>
void place(const Comm& comm, List& list) {
  const auto n = static_cast<std::int64_t>(list.verts.size());
  list.first = comm.exclusive_sum(n), list.total = comm.sum(n);
}

/// The same bytes as items of another type: identifiers and points are numbers for a caller. `from` is freed.
template <class To, class From>
std::vector<To> converted(std::vector<From> from) {
  static_assert(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To> && std::is_trivially_copyable_v<From>);
  std::vector<To> to(from.size());
  if (!from.empty()) std::memcpy(static_cast<void*>(to.data()), from.data(), from.size() * sizeof(From));
  return to;
}

}  // namespace skein
