// Sizes, bounds and freezing by patch and region.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/tensor.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// What holds on some patches (references of triangles) or in some regions (references of tetrahedra).
struct LocalRule {
  enum class On { kPatches, kRegions, kBoth };
  On on = On::kPatches;
  std::vector<std::int32_t> refs;  ///< references
  double h_min = 0, h_max = 0;     ///< length; 0: as elsewhere. The same number twice is a size
  enum class Change { kAllowed, kNone };
  Change change = Change::kAllowed;  ///< kNone: the triangles or tetrahedra stay as they are
  std::string where;                 ///< of the rule, for messages
};

/// Bounds of the eigenvalues of log M at the vertices of a mesh, made once of all rules.
class LocalBounds {
 public:
  LocalBounds() = default;
  /// Collective. Where rules meet, the finest bound counts, and the upper bound of the size before the lower.
  LocalBounds(const Comm& comm, const DistMesh& dist, const std::vector<LocalRule>& rules);
  /// Bounds of a rule take the place of those from elsewhere: they are applied last.
  void apply(std::span<SymTensor> log_metric) const;

 private:
  std::vector<double> low_, high_;  // per vertex, of the eigenvalues; -infinity: no rule says so. Empty: none at all
};

/// Collective. Makes the triangles and tetrahedra of the rules that allow no change required ones. Throws Error(kInput)
/// on all ranks for a rule with a reference that no patch, or no region, of the mesh has.
void apply_to_entities(const Comm& comm, const std::vector<LocalRule>& rules, MeshSlice& mesh);

}  // namespace skein
