// The flow of an adaptation.
#include "api/adaptation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "api/on_surface.hpp"
#include "api/values.hpp"
#include "base/text.hpp"
#include "metric/complexity.hpp"
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

/// How far from what was wanted a complexity or a count may be without a word.
constexpr double kMet = 0.05;

void note_complexity(PhaseLog& log, const MetricReport& r, const MetricPolicy& policy) {
  if (policy.complexity == 0 || std::abs(r.complexity / policy.complexity - 1) < kMet) return;
  log.note(
      fmt::format("note: the metric has a complexity of {:.4g}, not of {:.4g}: the bounds of the sizes allow no more",
                  r.complexity, policy.complexity));
}

/// Collective. A solution without second derivatives gives a uniform mesh.
void note_constant_field(const Comm& comm, const DistMesh& dist, const MetricPolicy& policy, PhaseLog& log) {
  if (policy.source != MetricSource::kField) return;
  const VertFields& f = dist.mesh.fields;
  const int n = comm.max(f.width);
  for (int k = 0; k < n; ++k) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t v = 0; v < f.size(); ++v) {
      const double x = f.values[v * static_cast<std::size_t>(n) + static_cast<std::size_t>(k)];
      low = std::min(low, x), high = std::max(high, x);
    }
    low = comm.min(low), high = comm.max(high);
    if (low == high)
      log.note(
          fmt::format("note: {}: the field is {} everywhere; it asks for no size but a uniform one", policy.name, low));
  }
}

/// Before the work: what it will come to. Seconds are rough: they hang on the processor and on how much there is to do.
void note_prediction(const Comm& comm, const AdaptationReport& r, int threads, PhaseLog& log) {
  log.expect(std::llround(r.predicted_tets));
  constexpr double kTetsPerSecond = 1.2e5;  ///< and worker; measured on one core of a server, metrics of many kinds
  const double workers = static_cast<double>(comm.size()) * threads;
  log.note(fmt::format(
      "expected: {} tetrahedra (complexity {:.4g}), {:.2g} GB in each process, about {:.0f} s where "
      "each of the {:.0f} workers has a core",
      grouped(std::llround(r.predicted_tets)), r.complexity, 1e-9 * kBytesPerTet * r.predicted_tets / comm.size(),
      std::ceil(r.predicted_tets / (kTetsPerSecond * workers)), workers));
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

constexpr int kMostCorrections = 3;
constexpr double kCloseEnough = 0.04;       ///< of the logarithm of a count
constexpr double kComplexityClose = 0.048;  ///< of the logarithm of the result's complexity

/// Adapts, with a wanted complexity met on the grown mesh: a coarse one does not know all of the metric.
void adapt_to_complexity(const Comm& comm, DistMesh& dist, const AdaptationOptions& options, double complexity,
                         PhaseLog& log) {
  AdaptOptions o = options.adapt;
  o.grown = [&](DistMesh& grown) {
    const double now = complexity_from_log(comm, grown, grown.mesh.log_metric.raw());
    rescale(comm, grown, options.metric, complexity / now);
  };
  adapt(comm, dist, o, log);
}

/// Collective. The result has `complexity`: if the metric turns out to be of less or more, it is scaled, and the mesh
/// adapted to that once more.
void meet_complexity(const Comm& comm, DistMesh& dist, const AdaptationOptions& options, double complexity,
                     PhaseLog& log) {
  adapt_to_complexity(comm, dist, options, complexity, log);
  const double factor = complexity / complexity_from_log(comm, dist, dist.mesh.log_metric.raw());
  if (std::abs(std::log(factor)) < kComplexityClose) return;
  log.note(fmt::format("adapts again: the result has {:.3g} times the complexity wanted", 1 / factor));
  rescale(comm, dist, options.metric, factor);
  adapt(comm, dist, options.adapt, log);
}

/// Collective. The count that is wanted, over that of the mesh.
double lack(const DistMesh& dist, const WantedCount& wanted) noexcept {
  return wanted.elements > 0 ? wanted.elements / static_cast<double>(dist.global_tets)
                             : wanted.vertices / static_cast<double>(dist.global_verts);
}

/// Collective. The result has the wanted count. If not, the input is adapted again to a metric scaled by what was
/// lacking: the result itself would hardly change, as edges stay until they are far too long or too short.
void meet_count(const Comm& comm, DistMesh& dist, const AdaptationOptions& options, double complexity, PhaseLog& log) {
  DistMesh given = dist;
  for (int i = 0;; ++i) {
    adapt_to_complexity(comm, dist, options, complexity, log);
    const double factor = lack(dist, options.wanted);
    if (std::abs(std::log(factor)) < kCloseEnough) return;
    if (i == kMostCorrections) {
      if (std::abs(factor - 1) > kMet)
        log.note(fmt::format("note: the result has {:.3g} times what is wanted; {} attempts came no nearer", 1 / factor,
                             i + 1));
      return;
    }
    log.note(fmt::format("begins again: the result has {:.3g} times what is wanted", 1 / factor));
    rescale(comm, given, options.metric, factor);
    complexity *= factor;
    dist = given;
  }
}

/// Collective. Adapts such that what is wanted is met on the result; `complexity` is what the bounds allow of it.
void meet_wanted(const Comm& comm, DistMesh& dist, const AdaptationOptions& options, double complexity, PhaseLog& log) {
  if (options.wanted.given()) return meet_count(comm, dist, options, complexity, log);
  if (options.metric.complexity > 0) return meet_complexity(comm, dist, options, complexity, log);
  adapt(comm, dist, options.adapt, log);
}

/// Collective. The slices are gone when it returns.
DistMesh distribute_input(const Comm& comm, AdaptationInput&& from, const AdaptationOptions& o, PhaseLog& log) {
  log.start("distribute");
  const AdaptationInput input = std::move(from);
  DistributeOptions options = o.distribute;
  options.metric_first = o.metric.source == MetricSource::kTensors || o.metric.source == MetricSource::kSizes;
  DistributeReport found;
  DistMesh dist = distribute(comm, input.mesh, input.values.width > 0 ? &input.values : nullptr, options, &found);
  log.finish(local_tets(dist));
  note_findings(log, found);
  return dist;
}

}  // namespace

double usual_gradation(MetricSource source) noexcept { return source == MetricSource::kSizes ? kSizeGradation : 0; }

double complexity_for(const WantedCount& wanted) noexcept {
  return wanted.elements > 0 ? wanted.elements / kResultTetsPerComplexity : wanted.vertices / kResultVertsPerComplexity;
}

FieldSlice side_by_side(FieldSlice a, const FieldSlice& b) {
  if (a.width == 0) return b;
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
                        const std::function<void(const std::string&)>& step_done, AdaptationReport* report) {
  const auto done = [&](const char* step) {
    if (step_done) step_done(step);
  };
  const int width = input.carried;
  const MeshSlice of_geometry = std::move(input.geometry);
  DistMesh dist = distribute_input(comm, std::move(input), options, log);

  AdaptationReport told;
  log.start("invariants");
  Invariants before = invariants(comm, dist);
  told.before = census(comm, dist);
  log.finish(local_tets(dist));
  log.note("input: " + to_line(told.before));

  log.start("metric");
  VertFields fields = take_carried(dist, width);
  note_constant_field(comm, dist, options.metric, log);
  const MetricReport made = make_metric(comm, dist, options.metric);
  told.complexity = made.complexity;
  told.predicted_tets = require_affordable(comm, dist, options.metric.name, options.metric.max_tets);
  Carrier carrier(comm, dist, std::move(fields));
  log.finish(local_tets(dist));
  note_gradation(log, made, dist.global_verts);
  note_complexity(log, made, options.metric);
  note_prediction(comm, told, options.adapt.threads, log);
  done("distribute");

  told.surface = adapt_on_surface(comm, dist, of_geometry, options, log, before, [&](const AdaptationOptions& on) {
    meet_wanted(comm, dist, on, made.complexity, log);
  });
  done("adapt");
  log.start("end check");
  told.end_check = end_check(comm, before, dist, options);
  log.finish(local_tets(dist));
  if (report != nullptr) *report = std::move(told);
  done("end check");
  if (!carrier.has_any()) return dist;
  carrier.arrive(dist, options.adapt.threads, log);
  done("transfer");
  return dist;
}

}  // namespace skein
