// A mesh in parts, as solvers have it: to slices, and back from the parts of Skein.
#pragma once
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "skein/skein.hpp"

namespace skein {

/// A mesh in parts as slices: every vertex on one rank, in the order of the global numbers, and what hangs on it.
struct SlicedParts {
  SlicedMesh mesh;
  std::vector<double> values;  ///< of the slice's vertices
};

/// Collective. values: `width` numbers per local vertex. What several ranks have (vertices, triangles, edges) comes
/// from the lowest of them; marks, such as corner and ridge, count if any of them has them. Throws Error(kInvalidMesh)
/// on all ranks for local numbers out of range, global numbers that are negative or twice on a rank, and copies of a
/// vertex at different places.
SlicedParts to_slices(const Comm& comm, PartitionedMesh mesh, std::vector<double> values, std::size_t width);

/// Collective. The parts as arrays: local numbers are those of `dist`, which is taken apart.
PartitionedMesh to_partitioned_mesh(const Comm& comm, DistMesh&& dist);

}  // namespace skein
