// Mean squares of edges, and their inverse.
#include "solution/own_metric.hpp"

#include <array>
#include <cmath>

#include "comm/halo.hpp"
#include "metric/complexity.hpp"
#include "solution/metric_policy.hpp"

namespace skein {
namespace {

constexpr double kFlattest = 1e-12;  ///< least against largest eigenvalue of C: an aspect ratio of a million
constexpr int kWidth = 7;            ///< numbers per vertex: C and how many edges

/// This rank's share of sum e e' and of the number of edges, at each vertex.
std::vector<double> edge_squares(const TetMesh& m) {
  std::vector<double> sum(m.vert_slots() * kWidth, 0);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < kEdgeVerts.size(); ++k) {
      const auto [a, b] = m.edge_verts(t, k);
      const Vec3 e = m.coords[b] - m.coords[a];
      const std::array<double, kWidth> square{e.x * e.x, e.x * e.y, e.y * e.y, e.x * e.z, e.y * e.z, e.z * e.z, 1};
      for (const VertId v : {a, b}) {
        for (std::size_t i = 0; i < kWidth; ++i) sum[idx(v) * kWidth + i] += square[i];
      }
    }
  }
  return sum;
}

/// -log(3 C) of C = s / n, its eigenvalues bounded from below: slivers have flat neighbourhoods.
SymTensor log_of_inverse(const double* s) {
  Eigen e = eigen({s[0], s[1], s[2], s[3], s[4], s[5]});
  const double least = std::max(kFlattest * e.value[2], 1e-300);
  for (double& value : e.value) value = -std::log(3 * std::max(value, least) / s[6]);
  return compose(e);
}

}  // namespace

std::vector<SymTensor> own_log_metric(const Comm& comm, const DistMesh& dist) {
  std::vector<double> sum = edge_squares(dist.mesh);
  Halo(comm, dist.sharing).sum<double>(sum, kWidth);
  std::vector<SymTensor> log_metric(dist.mesh.vert_slots());
  for (std::size_t v = 0; v < log_metric.size(); ++v) log_metric[v] = log_of_inverse(sum.data() + v * kWidth);
  const double wanted = static_cast<double>(dist.global_tets) / kResultTetsPerComplexity;
  scale_complexity(wanted / complexity_from_log(comm, dist, log_metric), log_metric);
  return log_metric;
}

}  // namespace skein
