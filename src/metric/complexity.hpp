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

/// Four numbers, one at each vertex of a tetrahedron.
using AtVerts = std::array<double, 4>;

// Quadratures: the mean of sqrt(det M) over a tetrahedron.

/// Vertices only: exact where sqrt(det M) is linear. Cheapest, and what the complexity of a metric is defined by here.
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

/// How many tetrahedra of a unit mesh take the place of one with this mean of sqrt(det M) and six times this volume.
inline double tets_of_unit_mesh(double mean_sqrt_det, double volume6) noexcept {
  return kTetsPerComplexity * mean_sqrt_det * std::abs(volume6) / 6;
}

/// The complexity over all live tetrahedra of the mesh by the vertex rule; sqrt_det(v) is that of M at vertex v.
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
