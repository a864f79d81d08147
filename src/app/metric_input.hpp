// The metric that the user gives: tensors, sizes, or a field whose Hessian makes it.
#pragma once
#include <CLI/App.hpp>
#include <string>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "solution/gradation.hpp"

namespace skein::app {

struct MetricOptions {
  std::string metric;               ///< solution with a symmetric tensor per vertex
  std::string size;                 ///< solution with an edge length per vertex
  std::string field;                ///< solution with a scalar per vertex
  double complexity = 0;            ///< 0: as given
  double h_min = 0, h_max = 1e300;  ///< length
  double norm = 2;                  ///< of the interpolation error of `field`: L^p, p >= 1 or infinity
  double gradation = 0;             ///< largest growth of sizes from edge to edge, > 1; 0: as they are
  [[nodiscard]] bool given() const noexcept { return !metric.empty() || !size.empty() || !field.empty(); }
  [[nodiscard]] const std::string& path() const noexcept {
    return !metric.empty() ? metric : !size.empty() ? size : field;
  }
};

/// --metric and --size, --complexity.
void add_metric_options(CLI::App& verb, MetricOptions& o);

/// Collective. Reads the file given: the logarithm of the metric (6 numbers per vertex) for --metric and --size, the
/// scalar itself for --field. Throws Error(kInput) with vertex number and eigenvalues when a metric is not positive
/// definite, and with both counts when it does not fit the mesh. @pre o.given()
FieldSlice read_metric(const Comm& comm, const MeshSlice& mesh, const MetricOptions& o);

/// Collective. Makes the column log_metric the logarithm of the metric to adapt to: --metric and --size are scaled to
/// the complexity (if given), then clamped to the sizes; --field becomes the metric of its second derivatives, which
/// meets the complexity with the clamps. With o.gradation sizes are graded after the clamps (which they then still
/// keep), and the scaling is such that the graded metric has the complexity. Tells what the gradation did. @pre
/// log_metric (--metric,
/// --size) or `fields` (--field) is what read_metric() gave.
GradationReport make_metric(const Comm& comm, DistMesh& dist, const MetricOptions& o);

}  // namespace skein::app
