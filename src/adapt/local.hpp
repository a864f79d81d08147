// Adapting one rank's mesh with its threads; the interface to other ranks stays as it is.
#pragma once
#include <cstddef>

#include "kernel/part.hpp"

namespace skein {

struct LocalOptions {
  int threads = 1;
  KernelOptions kernel;
  const SpacingField* spacing = nullptr;           ///< not owned
  const Geometry* geometry = &default_geometry();  ///< not owned
};
struct LocalResult {
  OperationCounts counts;
  /// For vertices that were frozen on entry: their new numbers. kNoVert for others.
  IdVector<VertId, VertId> old2new;
  bool turning = false;  ///< KernelOptions::turning for bands of the result
};

/// Adapts the mesh where vertices are kActive, leaving kFrozen ones as they are, with `threads` threads: the mesh is
/// cut into blocks, each adapted by a thread; then the interfaces of the blocks are moved and their bands worked on
/// again. The result is compact; kActive is of no meaning in it. Not collective. The same input and threads give the
/// same result. @pre the mesh has log_metric and metric.
LocalResult adapt_local(TetMesh& mesh, const LocalOptions& options);

}  // namespace skein
