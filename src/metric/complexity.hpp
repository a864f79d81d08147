// Complexity of a metric: the integral of sqrt(det M) over the mesh, and what a unit mesh will count.
#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "mesh/tet_mesh.hpp"
#include "metric/measure.hpp"

namespace skein {

/// What a unit mesh has per unit of complexity, about: measured on meshes of many metrics.
inline constexpr double kTetsPerComplexity = 10, kVertsPerComplexity = 1.7;

/// The same for what an adaptation of a mesh of some ten thousand tetrahedra and more makes: not quite a unit mesh.
/// Measured 10.7 to 11.5 tetrahedra, fewest where the metric varies most. Of vertices 1.9 to 2.3, most where much of
/// the mesh is boundary.
inline constexpr double kResultTetsPerComplexity = 11, kResultVertsPerComplexity = 2.0;

/// Four numbers, one at each vertex of a tetrahedron.
using AtVerts = std::array<double, 4>;

// Quadratures: the mean of sqrt(det M) over a tetrahedron.

/// Vertices only: exact where sqrt(det M) is linear. Cheap.
constexpr double vertex_rule(const AtVerts& sqrt_det) noexcept {
  return (sqrt_det[0] + sqrt_det[1] + sqrt_det[2] + sqrt_det[3]) / 4;
}
/// Vertices and centroids of the faces, exact for cubics, of exp(l), where l = log_sqrt_det() is linear. For elements
/// within which the metric varies much: there the vertices alone tell little.
inline double vertex_face_rule(const AtVerts& l) noexcept {
  const double sum = l[0] + l[1] + l[2] + l[3];
  double verts = 0, faces = 0;
  for (const double at : l) {
    verts += std::exp(at);
    faces += std::exp((sum - at) / 3);
  }
  return (verts + 9 * faces) / 40;
}
/// The centroid only, l as above: one exponential, and the least of the three.
inline double centroid_rule(const AtVerts& l) noexcept { return std::exp(0.25 * (l[0] + l[1] + l[2] + l[3])); }

/// The mean of exp(l), l linear: what the adaptation sees, which interpolates the logarithm of the metric. To 1 % or
/// better wherever it varies, and the complexity of a metric is defined by it here. On a coarse mesh with a metric that
/// varies by orders of magnitude within elements the rules above are wrong by factors.
double mean_of_log_linear(const AtVerts& l) noexcept;

/// How many tetrahedra of a unit mesh take the place of one with this mean of sqrt(det M) and six times this volume.
inline double tets_of_unit_mesh(double mean_sqrt_det, double volume6) noexcept {
  return kTetsPerComplexity * mean_sqrt_det * std::abs(volume6) / 6;
}

/// An estimate of it over all live tetrahedra of the mesh by the vertex rule; sqrt_det(v) is that of M at vertex v.
template <class SqrtDet>
double complexity_of(const TetMesh& mesh, SqrtDet&& sqrt_det) {
  double sum = 0;
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    if (!mesh.is_live(t)) continue;
    const auto& v = mesh.tet2vert[t];
    sum +=
        vertex_rule({sqrt_det(v[0]), sqrt_det(v[1]), sqrt_det(v[2]), sqrt_det(v[3])}) * std::abs(volume6(mesh, t)) / 6;
  }
  return sum;
}

/// The complexity over all live tetrahedra of the mesh; log_density(v) is log_sqrt_det() at vertex v.
template <class LogDensity>
double complexity_of_log(const TetMesh& mesh, LogDensity&& log_density) {
  double sum = 0;
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    if (!mesh.is_live(t)) continue;
    const auto& v = mesh.tet2vert[t];
    const AtVerts l{log_density(v[0]), log_density(v[1]), log_density(v[2]), log_density(v[3])};
    sum += mean_of_log_linear(l) * std::abs(volume6(mesh, t)) / 6;
  }
  return sum;
}

/// The vertex rule as weights: the complexity is the sum of weight * sqrt(det M) over the vertices. One per vertex: a
/// quarter of the volume of the tetrahedra at it. @pre no free slots
inline std::vector<double> vertex_rule_weights(const TetMesh& mesh) {
  std::vector<double> weight(mesh.vert_slots(), 0);
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    const double quarter = volume6(mesh, t) / 24;
    for (const VertId v : mesh.tet2vert[t]) weight[idx(v)] += quarter;
  }
  return weight;
}

}  // namespace skein
