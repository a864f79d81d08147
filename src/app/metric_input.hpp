// The options and files of what the mesh is adapted to: tensors, sizes, solutions whose Hessians make the metric, the
// mesh's own sizes; with the local sizes, sources and bounds that go with them.
#pragma once
#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <vector>

#include "api/adaptation.hpp"
#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"
#include "solution/metric_policy.hpp"

namespace skein::app {

/// FILE or FILE:N, N the number of a field in it, from 1.
struct FieldPath {
  std::string file;
  std::optional<int> number;
};
FieldPath to_field_path(const std::string& word);

struct MetricOptions {
  std::vector<std::string> metric;  ///< solutions with a symmetric tensor per vertex
  std::vector<std::string> size;    ///< solutions with an edge length per vertex, and numbers: uniform lengths
  std::vector<std::string> field;   ///< solutions with a scalar per vertex
  bool optim = false;               ///< the mesh's own sizes
  std::string sources, local;       ///< files
  std::vector<std::string> freeze;  ///< references, each alone or as patch:R or region:R
  std::optional<double> gradation;
  WantedCount wanted;
  MetricPolicy numbers;  ///< all but the source, the name, and what is in files

  [[nodiscard]] bool given() const noexcept {
    return !metric.empty() || !size.empty() || !field.empty() || optim || !sources.empty();
  }
  [[nodiscard]] MetricSource source() const noexcept;
  /// The words of the option that is given; none for the mesh's own sizes.
  [[nodiscard]] const std::vector<std::string>& words() const noexcept;
  /// All files.
  [[nodiscard]] std::vector<std::string> files() const;
};

/// --metric and --size, --complexity.
void add_metric_options(CLI::App& verb, MetricOptions& o);
/// The rest of them, which adapt has.
void add_adapt_metric_options(CLI::App& verb, MetricOptions& o);

/// Collective. Throws Error(kUsage) for options that make no sense together, Error(kInput) for missing files.
void require_metric(const Comm& comm, const MetricOptions& o);
/// Collective. The policy with what is in the files of sources and local sizes, and with --freeze-ref as a rule.
MetricPolicy read_policy(const Comm& comm, const MetricOptions& o);

/// Collective. Reads the files given and makes metric_values() of them: of several metrics and sizes the strictest, of
/// solutions one column each. Throws Error(kInput) on all ranks as that does, and with both counts when a file does not
/// fit the mesh. @pre o.given()
FieldSlice read_metric(const Comm& comm, const MeshSlice& mesh, const MetricOptions& o);

}  // namespace skein::app
