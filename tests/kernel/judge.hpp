// Judging an operation from outside: a part before and after it.
#pragma once
#include <string>
#include <vector>

#include "kernel/part.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::test {

/// What of a part counts; not its scratch memory.
struct Snapshot {
  TetMesh mesh;
  IdVector<TetId, float> q3;
  QualityMeasure quality_measure;
  explicit Snapshot(const Part& p) : mesh(p.mesh), q3(p.q3), quality_measure(p.quality_measure) {}
};

/// Empty when all that lives is the same bit by bit. Free slots may have come.
std::string differ(const Snapshot& before, const Part& after);

/// The tetrahedra that an operation has replaced, and those in their place. Qualities are cubed, computed afresh.
struct Change {
  std::vector<TetId> gone, fresh;
  double old_min = 1, new_min = 1;
  double old_sum = 0, new_sum = 0;
};
/// Tetrahedra at vertex `moved` count as replaced by themselves.
Change change(const Snapshot& before, const Part& after, VertId moved = kNoVert);

/// Empty when the part is valid, its cached qualities are right, and all that no operator may touch is as it was:
/// frozen vertices and interface faces (bit by bit), vertices outside the change, corners, required vertices and
/// triangles, and, if `tolerance` > 0, volumes, areas and feature lengths up to it. Otherwise the first fault.
/// `moved`: the one vertex that may have moved.
std::string judge(const Snapshot& before, const Part& after, double tolerance, VertId moved = kNoVert);
/// The part of it that needs no history.
std::string judge(const Part& part);

}  // namespace skein::test
