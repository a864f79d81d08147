// The options and files of the metric that the user gives: tensors, sizes, or a field whose Hessian makes it.
#pragma once
#include <CLI/App.hpp>
#include <string>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "solution/metric_policy.hpp"

namespace skein::app {

struct MetricOptions {
  std::string metric;    ///< solution with a symmetric tensor per vertex
  std::string size;      ///< solution with an edge length per vertex
  std::string field;     ///< solution with a scalar per vertex
  MetricPolicy numbers;  ///< all but the source and the name
  [[nodiscard]] bool given() const noexcept { return !metric.empty() || !size.empty() || !field.empty(); }
  [[nodiscard]] const std::string& path() const noexcept {
    return !metric.empty() ? metric : !size.empty() ? size : field;
  }
  [[nodiscard]] MetricPolicy policy() const;
};

/// --metric and --size, --complexity.
void add_metric_options(CLI::App& verb, MetricOptions& o);

/// Collective. Reads the file given and makes metric_values() of it. Throws Error(kInput) on all ranks as that does,
/// and with both counts when the file does not fit the mesh. @pre o.given()
FieldSlice read_metric(const Comm& comm, const MeshSlice& mesh, const MetricOptions& o);

}  // namespace skein::app
