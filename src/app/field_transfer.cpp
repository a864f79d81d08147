// The fields that travel with the mesh.
#include "app/field_transfer.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "app/files.hpp"
#include "base/text.hpp"
#include "dist/migrate.hpp"
#include "dist/partition.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {
namespace {

/// Vertex by vertex the numbers of a, then those of b.
std::vector<double> side_by_side(const std::vector<double>& a, int width_a, const std::vector<double>& b, int width_b) {
  const auto wa = static_cast<std::size_t>(width_a), wb = static_cast<std::size_t>(width_b);
  std::vector<double> out(a.size() + b.size());
  for (std::size_t i = 0; i * (wa + wb) < out.size(); ++i) {
    std::copy_n(a.data() + i * wa, wa, out.data() + i * (wa + wb));
    std::copy_n(b.data() + i * wb, wb, out.data() + i * (wa + wb) + wa);
  }
  return out;
}

/// "mach" for some/mach.solb, "state_2" for the second of several fields in it.
std::string field_name(const std::string& path, std::size_t i, std::size_t n) {
  std::string stem = path.substr(path.find_last_of('/') + 1);
  stem = stem.substr(0, stem.find_last_of('.'));
  return n == 1 ? stem : fmt::format("{}_{}", stem, i + 1);
}

}  // namespace

void add_field_options(CLI::App& verb, FieldOptions& o) {
  verb.add_option("--field-in", o.in, "solution of any fields to be carried to the new mesh; may be repeated")
      ->allow_extra_args(false);
  verb.add_option("--field-out", o.out, "these fields at the vertices of the new mesh (.sol, .solb)");
}

void require_fields(const Comm& comm, const FieldOptions& o, const std::string& output) {
  agree(comm, [&] {
    if (o.in.empty() && !o.out.empty()) {
      throw Error(ExitCode::kUsage, "adapt: --field-out needs --field-in, the fields that shall be carried over");
    }
    if (!o.in.empty() && o.out.empty() && !has_ending(output, {".vtu", ".pvtu"})) {
      throw Error(ExitCode::kUsage, "adapt: --field-in needs --field-out, the solution file to write");
    }
  });
  for (const auto& path : o.in) require_input(comm, path, kFields);
  require_output(comm, o.out, kFields);
}

FieldSlice TravellingFields::read_behind(const Comm& comm, const MeshSlice& mesh, FieldSlice metric) {
  out_.path = options_.out;
  for (const auto& path : options_.in) {
    const FieldSlice f = read_fields(comm, path);
    agree(comm, [&] {
      if (f.total != mesh.total_verts) {
        throw Error(ExitCode::kInput, fmt::format("{}: {} values for the {} vertices of {}; give the one of this mesh",
                                                  path, f.total, mesh.total_verts, mesh.path));
      }
      metric.values = side_by_side(metric.values, metric.width, f.values, f.width);
      metric.width += f.width;
      for (std::size_t i = 0; i < f.kinds.size(); ++i) {
        metric.kinds.push_back(f.kinds[i]);
        out_.kinds.push_back(f.kinds[i]);
        out_.names.push_back(field_name(path, i, f.kinds.size()));
      }
    });
  }
  return metric;
}

void TravellingFields::take_from(DistMesh& dist, int keep) {
  if (!any()) return;
  const std::size_t n = dist.mesh.vert_slots();
  const VertFields& all = dist.mesh.fields;
  VertFields rest;
  rest.width = keep;
  values_.width = all.width - keep;
  values_.values.clear();
  for (const VertId v : IdRange<VertId>(n)) {
    const double* d = all.at(v);
    rest.values.insert(rest.values.end(), d, d + keep);
    values_.values.insert(values_.values.end(), d + keep, d + all.width);
  }
  dist.mesh.fields = std::move(rest);
}

void TravellingFields::keep_mesh(const Comm& comm, DistMesh& dist) {
  if (!any()) return;
  old_.emplace(comm, dist, std::move(values_));
}

void TravellingFields::arrive(DistMesh& dist, int threads, PhaseLog& log) {
  if (!any()) return;
  log.start("transfer fields");
  TransferReport report;
  dist.mesh.fields = old_->at_vertices(dist, threads, &report);
  old_.reset();
  log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  if (report.outside == 0) return;
  log.note(
      fmt::format("note: {} vertices outside of the old mesh, by up to {:.3g}, have the fields of its nearest point",
                  grouped(report.outside), report.farthest));
}

}  // namespace skein::app
