// The flow of an adaptation.
#include "api/adaptation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "api/on_surface.hpp"
#include "api/values.hpp"
#include "base/text.hpp"
#include "solution/demand.hpp"
#include "solution/transfer.hpp"

namespace skein {
namespace {

constexpr double kSizeGradation = 1.3;

void note_findings(PhaseLog& log, const DistributeReport& r) {
  const auto note = [&](std::int64_t n, const char* what) {
    if (n > 0) log.note(fmt::format("note: {} {}", grouped(n), what));
  };
  note(r.turned_tets, "tetrahedra were negatively oriented and have been turned");
  note(r.double_tets, "tetrahedra were given again and are dropped");
  note(r.double_triangles, "triangles were given again and are dropped");
  note(r.double_edges, "edges were given again and are dropped");
  note(r.crack_verts, "pairs of vertices at one place stay apart: both sides have triangles (a crack)");
  note(r.untagged_hull_faces, "faces of the hull have no triangle; they become a patch of their own");
  note(r.untagged_region_faces, "faces between regions have no triangle; they become a patch of their own");
  note(r.unused_verts, "vertices of no tetrahedron are dropped");
  note(r.lost_edges, "edges are no edge of a tetrahedron and are dropped");
}

void note_gradation(PhaseLog& log, const GradationReport& r, std::int64_t vertices) {
  if (r.lowered > 0) {
    log.note(fmt::format("gradation: stricter at {} of {} vertices", grouped(r.lowered), grouped(vertices)));
  }
  if (!r.converged) log.note("note: the gradation has not converged; sizes may still grow faster in places");
}

void note_transfer(PhaseLog& log, const TransferReport& r) {
  if (r.outside == 0) return;
  log.note(
      fmt::format("note: {} vertices outside of the old mesh, by up to {:.3g}, have the fields of its nearest point",
                  grouped(r.outside), r.farthest));
}

std::int64_t local_tets(const DistMesh& dist) noexcept { return static_cast<std::int64_t>(dist.mesh.tet_slots()); }

/// Takes the last `width` numbers of each vertex out of the mesh's fields.
VertFields take_carried(DistMesh& dist, int width) {
  VertFields& all = dist.mesh.fields;
  if (width == 0) return {};
  const int keep = all.width - width;
  VertFields carried{width, columns(all.values, all.width, keep, width)};
  all = {keep, columns(all.values, all.width, 0, keep)};
  return carried;
}

/// Collective. The old mesh with the fields on it, until they arrive at the new one.
class Carrier {
 public:
  Carrier(const Comm& comm, DistMesh& dist, VertFields fields) {
    if (fields.width > 0) old_.emplace(comm, dist, std::move(fields));
  }
  [[nodiscard]] bool has_any() const noexcept { return old_.has_value(); }
  /// Collective. Puts them onto the new mesh and forgets the old one.
  void arrive(DistMesh& dist, int threads, PhaseLog& log) {
    log.start("transfer fields");
    TransferReport report;
    dist.mesh.fields = old_->at_vertices(dist, threads, &report);
    old_.reset();
    log.finish(local_tets(dist));
    note_transfer(log, report);
  }

 private:
  std::optional<Background> old_;
};

/// Collective. The slices are gone when it returns.
DistMesh distribute_input(const Comm& comm, AdaptationInput&& from, const AdaptationOptions& o, PhaseLog& log) {
  log.start("distribute");
  const AdaptationInput input = std::move(from);
  DistributeOptions options = o.distribute;
  options.metric_first = o.metric.source != MetricSource::kField;
  DistributeReport found;
  DistMesh dist = distribute(comm, input.mesh, &input.values, options, &found);
  log.finish(local_tets(dist));
  note_findings(log, found);
  return dist;
}

}  // namespace

double usual_gradation(MetricSource source) noexcept { return source == MetricSource::kSizes ? kSizeGradation : 0; }

FieldSlice side_by_side(FieldSlice a, const FieldSlice& b) {
  a.values = side_by_side(a.values, a.width, b.values, b.width);
  a.width += b.width;
  a.kinds.insert(a.kinds.end(), b.kinds.begin(), b.kinds.end());
  return a;
}

EndCheckReport end_check(const Comm& comm, const Invariants& before, DistMesh& dist, const AdaptationOptions& options) {
  EndCheckReport report = compare(before, invariants(comm, dist), options.end_check);
  if (report.passed()) return report;
  if (options.suspect) options.suspect(std::move(dist));
  agree(comm, [&] {
    throw Error(ExitCode::kInternal, "the end check has found the result wrong, please report it: " + to_line(report));
  });
  return report;
}

DistMesh run_adaptation(const Comm& comm, AdaptationInput input, const AdaptationOptions& options, PhaseLog& log,
                        const std::function<void(const std::string&)>& step_done, AdaptationFindings* found) {
  const auto done = [&](const char* step) {
    if (step_done) step_done(step);
  };
  const int width = input.carried;
  const MeshSlice of_geometry = std::move(input.geometry);
  DistMesh dist = distribute_input(comm, std::move(input), options, log);

  log.start("invariants");
  Invariants before = invariants(comm, dist);
  log.finish(local_tets(dist));

  log.start("metric");
  VertFields fields = take_carried(dist, width);
  const GradationReport graded = make_metric(comm, dist, options.metric);
  require_affordable(comm, dist, options.metric.name, options.metric.max_tets);
  Carrier carrier(comm, dist, std::move(fields));
  log.finish(local_tets(dist));
  note_gradation(log, graded, dist.global_verts);
  done("distribute");

  AdaptationFindings findings;
  findings.surface = adapt_on_surface(comm, dist, of_geometry, options, log, before);
  done("adapt");
  log.start("end check");
  findings.end_check = end_check(comm, before, dist, options);
  log.finish(local_tets(dist));
  if (found != nullptr) *found = std::move(findings);
  done("end check");
  if (!carrier.has_any()) return dist;
  carrier.arrive(dist, options.adapt.threads, log);
  done("transfer");
  return dist;
}

}  // namespace skein
