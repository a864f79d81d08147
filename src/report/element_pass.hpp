// One look at every tetrahedron: volume, dihedral angles, quality.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "mesh/tet_mesh.hpp"
#include "metric/measure.hpp"

namespace skein {

/// Sums and extremes over some tetrahedra.
struct TetSums {
  std::int64_t nonpositive = 0;
  double volume = 0, min_volume = std::numeric_limits<double>::infinity();
  double complexity = 0;                  ///< integral of sqrt(det M); 0 without metrics
  double max_cos = -1, min_cos = 1;       ///< of the dihedral angles
  std::array<std::int64_t, 18> angles{};  ///< dihedral angles in classes of 10 degrees
  TetSums& operator+=(const TetSums& s) noexcept;
};

/// Of the tetrahedra [first, last). With a metric at the vertices: the quality of tetrahedron t goes to quality[t].
TetSums element_pass(const TetMesh& m, const IdVector<VertId, VertMetric>* metric, std::size_t first, std::size_t last,
                     std::span<double> quality);

}  // namespace skein
