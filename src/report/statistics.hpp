// Statistics of a distributed mesh: sizes, edge lengths and quality in the metric, dihedral angles.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Edge lengths in the metric (logarithmic mean of both ends); each edge once, also on interfaces.
struct LengthStatistics {
  double unit_share = 0;  ///< % in [1/sqrt 2, sqrt 2]
  double min = 0, p1 = 0, mean = 0, p99 = 0, max = 0;
  double below_half = 0, above_two = 0;  ///< % below 0.5, % from 2
  /// Edges by length; the bounds are length_bounds().
  std::array<std::int64_t, 14> histogram{};
};
/// The inner bounds of LengthStatistics::histogram: powers of 2^(1/4) from 1/2 to 2, and 1/4, 1/2.83, 2.83, 4 outside.
const std::array<double, 13>& length_bounds() noexcept;

/// Metric mean ratio: 1 for the unit tetrahedron, 0 for a flat one (and for inverted ones).
struct QualityStatistics {
  double min = 0, p01 = 0, p1 = 0, mean = 0;                      ///< p01: the 0.1st percentile
  double below_01 = 0, below_02 = 0, above_05 = 0, above_08 = 0;  ///< % below 0.1, 0.2; % from 0.5, 0.8
  std::array<std::int64_t, 10> histogram{};                       ///< tetrahedra in tenths
};

struct DihedralStatistics {
  double min = 0, max = 0;                         ///< degrees
  std::array<std::int64_t, 18> histogram_10deg{};  ///< the six angles of every tetrahedron
};

struct MeshStatistics {
  std::int64_t tets = 0, vertices = 0, edges = 0, nonpositive_tets = 0;
  double volume = 0, min_volume = 0;  ///< length^3 of the input
  DihedralStatistics dihedral;
  bool with_metric = false;  ///< the rest is there only then
  double complexity = 0;     ///< integral of sqrt(det M)
  LengthStatistics length;
  QualityStatistics quality;
};

/// How lengths and qualities are measured.
enum class Measure {
  kInSpace,  ///< angles and volumes only
  kInMetric  ///< in the metric of the mesh, too. @pre it has a log_metric
};

/// Collective. The same on every rank. With a metric: its logarithm is the column log_metric.
/// Counts, extremes and percentiles do not depend on the number of ranks; sums do by rounding.
MeshStatistics statistics(const Comm& comm, const DistMesh& dist, Measure measure, int threads = 1);

/// A few lines for people, with small histograms.
std::string to_text(const MeshStatistics& s);

}  // namespace skein
