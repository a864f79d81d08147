// The rounds over the ranks.
#include "adapt/adapt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <string>

#include "adapt/band.hpp"
#include "adapt/blocks.hpp"
#include "adapt/grow.hpp"
#include "adapt/local.hpp"
#include "adapt/stretch.hpp"
#include "base/parallel.hpp"
#include "dist/interface.hpp"
#include "dist/migrate.hpp"
#include "dist/partition.hpp"
#include "dist/rebalance.hpp"
#include "dist/reconcile.hpp"
#include "dist/sharing.hpp"
#include "kernel/interface.hpp"
#include "mesh/adjacency.hpp"
#include "solution/transfer.hpp"

namespace skein {
namespace {

/// Collective. Tells whether the metric has directions anywhere. `least`: what differs in the logarithm of 1/length^2.
bool has_directions(const Comm& comm, const DistMesh& dist, double least) {
  std::int32_t found = 0;
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    const SymTensor& l = dist.mesh.log_metric[v];
    const double mean = (l.xx + l.yy + l.zz) / 3;
    const auto off = [&](double diagonal) { return std::abs(diagonal - mean); };
    const double most = std::max({off(l.xx), off(l.yy), off(l.zz), std::abs(l.xy), std::abs(l.xz), std::abs(l.yz)});
    found |= most > least ? 1 : 0;
  }
  return comm.max(found) != 0;
}

/// Collective. Refines the interface between ranks where its edges are too long for the metric, on both sides alike;
/// not at all if that fails on any rank.
void refine_rank_interface(const Comm& comm, DistMesh& dist, const LocalOptions& options) {
  Part part;
  IdVector<VertId, GlobalId> gid = dist.vert2gid;
  std::int32_t failed = 0;
  agree(comm, [&] {
    part.options = options.kernel;
    part.spacing = options.spacing;
    part.geometry = options.geometry;
    part.mesh = dist.mesh;
    measure_metric(part.mesh);
    prepare(part);
    failed =
        refine_interface(part, gid, {.of_class = options.kernel.may_change_surface() ? VertClass{} : kSurface}) ? 0 : 1;
  });
  if (comm.max(failed) != 0 || comm.sum(part.counts.insert) == 0) return;
  agree(comm, [&] {
    dist.mesh = std::move(part.mesh);
    dist.mesh.metric = {};
    dist.vert2gid = std::move(gid);
  });
  rebuild_sharing(comm, dist);
  // A rank may have the middle of an edge's shell only and not know that a new vertex on it is on the surface.
  merge_vertex_flags(comm, dist);
  renumber_compact(comm, dist);
}

/// The local part of the first round: the kernel on all of this rank's mesh. Not collective.
LocalResult adapt_rank(DistMesh& dist, const LocalOptions& options) {
  measure_metric(dist.mesh);
  LocalResult r = adapt_local(dist.mesh, options);
  dist.mesh.metric = {};
  const std::size_t n = dist.mesh.vert_slots(), room = n + n / 8;  // for what later rounds bring
  // Only shared vertices keep their numbers; they were frozen.
  IdVector<VertId, GlobalId> gid;
  gid.reserve(room);
  gid.resize(n, kNoGlobal);
  for (std::size_t i = 0; i < dist.sharing.size(); ++i) {
    dist.sharing.vert[i] = r.old2new[dist.sharing.vert[i]];
    gid[dist.sharing.vert[i]] = dist.sharing.gid[i];
  }
  dist.vert2gid = std::move(gid);
  return r;
}

/// The local part of a later round: the kernel on what is active, and nothing that costs as much as the whole mesh.
/// Not collective.
OperationCounts adapt_band(DistMesh& dist, LocalOptions options) {
  options.kernel.scope = Scope::kRetry;
  Band band = cut_band(dist.mesh, options.kernel.method.rounds.margin, options.threads);
  const LocalResult r = adapt_local(band.mesh, options);
  put_back(dist, band, r.old2new, options.threads);
  return r.counts;
}

/// A new interface along an old one would leave what lies there frozen again.
void make_old_interfaces_heavy(const DistMesh& dist, std::int32_t times, std::vector<std::int32_t>& cost) {
  constexpr std::int32_t kMost = 1000;  // that the partitioner takes
  const TetMesh& m = dist.mesh;
  const auto was_shared = [&](VertId v) { return m.has(v, kFrozen); };
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceId f = make_face(t, k);
      const auto v = m.verts(f);
      if (std::all_of(v.begin(), v.end(), was_shared)) cost[idx(f)] = std::min(kMost, times * cost[idx(f)]);
    }
  }
}

/// Collective. Compact parts of equal predicted work with small interfaces in the final mesh, which are then refined.
/// `grown`: on parts of the mesh the kernel has been at work before.
void cut_parts(const Comm& comm, DistMesh& dist, int parts, bool grown, const LocalOptions& local) {
  std::vector<double> work;
  std::vector<std::int32_t> cost;
  agree(comm, [&] {
    work = predicted_work(dist.mesh);
    measure_metric(dist.mesh);
    cost = face_costs(dist.mesh, local.threads);
    dist.mesh.metric = {};
    if (grown) make_old_interfaces_heavy(dist, local.kernel.method.rounds.old_interface_weight, cost);
  });
  MeshCutOptions options;
  options.face_weight = cost;
  options.imbalance = local.kernel.method.rounds.part_imbalance;
  options.threads = local.threads;
  migrate(comm, dist, multilevel_partition(comm, dist, work, parts, options));
  if (parts > 1) refine_rank_interface(comm, dist, local);
}

/// Collective. Equal numbers of tetrahedra for whatever comes next. Displaced interfaces have taken from some ranks and
/// given to others; ranks that had no part get one.
void even_out(const Comm& comm, DistMesh& dist, int parts, const Method::Rounds& o) {
  const auto most = static_cast<double>(comm.max(static_cast<std::int64_t>(dist.mesh.tet_slots())));
  if (most * comm.size() <= (1 + o.result_good_enough) * static_cast<double>(dist.global_tets)) return;
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  migrate(comm, dist,
          parts < comm.size() ? to_ranks(partition(comm, dist, work, comm.size()))
                              : rebalance(comm, dist, work, o.result_imbalance));
}

/// Collective. Moves the interfaces for the next round. Vertices of the first interface have numbers below
/// `never_free` for as long as they have been on one in every round; everywhere else the mesh has been worked on with
/// nothing frozen, and only what this has left in a bad state beside frozen vertices (kRetry) is looked at again. Tells
/// whether any are left; otherwise there is nothing to do.
bool move_interfaces(const Comm& comm, DistMesh& dist, int round, GlobalId never_free, const Method::Rounds& o) {
  const auto moves = [&]() -> std::optional<Moves> {
    const int layers = round == 1 ? o.layers : o.layers_later;
    InterfaceRegion region(comm, dist, std::max(o.active_layers, layers));
    if (!region.mark_active(o.active_layers, never_free)) return {};
    return region.displace(layers, round, never_free);
  }();
  if (!moves) return false;
  migrate(comm, dist, *moves);
  return true;
}

/// Collective. `work` on the rank's mesh as a phase of the log; its new vertices get the numbers from the returned one
/// on.
template <class Work>
GlobalId run_kernel(const Comm& comm, DistMesh& dist, const std::string& phase, PhaseLog& log, Work&& work) {
  log.start(phase);
  agree(comm, [&] {
    const double begin = wall_time();
    const OperationCounts c = work();
    log.busy(wall_time() - begin);
    log.count("insert", c.insert);
    log.count("collapse", c.collapse);
    log.count("swap", c.swap);
    log.count("smooth", c.smooth);
    log.count("poor_at_interface", c.poor_at_interface);
    log.count("poor_at_boundary", c.poor_at_boundary);
    log.count("poor_inside", c.poor_inside);
  });
  const GlobalId first = number_new_vertices(comm, dist);
  log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  return first;
}

/// Who works: parts, one per rank, and threads on each of them.
struct Workers {
  int parts = 1, threads = 1;
  bool grown = false;  ///< the mesh has grown in steps before
};
/// Threads cut a part again, so they are counted like parts.
Workers workers_for(const CutLimits& limits, int parts, int threads, bool grown) noexcept {
  return {parts, std::clamp(limits.able / parts, 1, threads), grown};
}

/// Whether the mesh goes another step towards a metric that stretches its elements far.
class StretchSteps {
 public:
  /// Collective. `elements` as in cut_limits().
  bool are_worth(const Comm& comm, DistMesh& dist, std::span<const double> elements, const Method::Growth& o) {
    measure_metric(dist.mesh);
    const StretchToDo now = stretch_to_do(comm, dist, elements, begun_ ? o.stretch_left : o.stretch_above);
    dist.mesh.metric = {};
    const bool worth =
        now.elements > o.stretch_least && (!begun_ || now.excess <= last_.excess - o.stretch_progress * last_.share);
    // The first step may do no more than make the mesh coarser across.
    last_ = begun_ ? now : StretchToDo{.excess = std::numeric_limits<double>::infinity()};
    begun_ = begun_ || worth;
    return worth;
  }

 private:
  bool begun_ = false;
  StretchToDo last_;  ///< before the step
};

/// Collective. Lets a mesh that is too small for all the parts that its final state can feed grow on fewer ranks, with
/// a coarser metric, until it can be cut. Interfaces through a few tetrahedra would have to be refined many times over
/// with next to nothing beside them, and what comes of that costs more than the parts gain. Steps, too, lead to a
/// metric that asks for elements far more stretched than those of the mesh.
Workers grow(const Comm& comm, DistMesh& dist, const LocalOptions& local, PhaseLog& log) {
  const Method::Growth& method = local.kernel.method.growth;
  // One worker alone does better, too: far from its final size, a mesh of few tetrahedra is all needles for a while.
  const int workers = std::max(2, comm.size() * local.threads);
  std::optional<Background> given;
  CutLimits last{};
  StretchSteps stretch_steps;
  for (int step = 0;; ++step) {
    const std::vector<double> elements = predicted_elements(dist.mesh);
    const CutLimits limits = cut_limits(comm, elements, workers, method);
    const bool helps = step == 0 || limits.able > last.able || limits.able == 1;
    const bool small = limits.able < limits.wanted && helps;
    // A spacing field is known where there are vertices only; nobody can tell what it will ask for.
    const bool may = local.spacing == nullptr && step < method.most_steps;
    const bool stretched = may && stretch_steps.are_worth(comm, dist, elements, method);
    if (!may || (!small && !stretched))
      return workers_for(limits, std::min(limits.wanted, comm.size()), local.threads, step > 0);
    last = limits;
    log.start(fmt::format("growth {}: partition", step + 1));
    if (!given) given.emplace(comm, dist, fields_of(dist.mesh.log_metric));
    if (small) bound_growth(comm, dist, elements, method.per_step);
    if (stretched) bound_stretch(comm, dist, method);
    const int parts = std::min({limits.able, limits.wanted, comm.size()});
    const Workers now = workers_for(limits, parts, local.threads, step > 0);
    LocalOptions step_options = local;
    step_options.threads = now.threads;
    if (comm.size() > 1) cut_parts(comm, dist, now.parts, step > 0, local);
    log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots()));
    run_kernel(comm, dist, fmt::format("growth {}: adapt", step + 1), log,
               [&] { return adapt_rank(dist, step_options).counts; });
    dist.mesh.log_metric = tensors_of(given->at_vertices(dist));
    for (VertState& s : dist.mesh.vert_state) s |= kActive;  // threads leave it to what they have looked at twice
  }
}

std::unique_ptr<Geometry> make_geometry(const AdaptOptions& o) {
  if (o.reference != nullptr && o.reference->shape() == SurfaceShape::kPatches)
    return std::make_unique<PatchGeometry>(o.method.facets, o.method.patches, *o.reference);
  return std::make_unique<FacetGeometry>(o.method.facets, o.reference);
}

}  // namespace

void adapt(const Comm& comm, DistMesh& dist, const AdaptOptions& options, PhaseLog& log) {
  LocalOptions local;
  local.threads = options.threads;
  local.spacing = options.spacing;
  local.kernel.method = options.method;
  local.kernel.surface = options.surface ? SurfaceChange::kAllowed : SurfaceChange::kNone;
  const auto geometry = make_geometry(options);
  local.geometry = geometry.get();
  agree(comm, [&] {
    if (dist.mesh.log_metric.size() != dist.mesh.vert_slots())
      throw Error(ExitCode::kInternal, "adapt needs the log-metric at the vertices");
  });
  const auto finish = [&] { log.finish(static_cast<std::int64_t>(dist.mesh.tet_slots())); };
  // Where lengths differ by direction, cavities fit less well, and every edge by itself is worth a look.
  const bool directed = has_directions(comm, dist, options.method.rounds.directed_above);
  for (VertState& s : dist.mesh.vert_state) s |= kActive;
  const auto [parts, threads, grown] = grow(comm, dist, local, log);
  local.threads = threads;
  if (grown && options.grown) options.grown(dist);
  log.start("round 1: partition");
  if (comm.size() > 1) cut_parts(comm, dist, parts, grown, local);
  finish();
  LocalOptions first = local;
  first.kernel.lower_strain = directed;
  if (grown) first.kernel.least_turns = options.method.main.least_turns_after_growth;
  bool turning = false;
  const GlobalId never_free = run_kernel(comm, dist, "round 1: adapt", log, [&] {
    const LocalResult r = adapt_rank(dist, first);
    turning = r.turning;
    return r.counts;
  });
  // Of the whole mesh: what most of it looks like.
  const auto tets = static_cast<std::int64_t>(dist.mesh.tet_slots());
  local.kernel.turning = 2 * comm.sum(turning ? tets : 0) > comm.sum(tets);
  bool more = parts > 1;
  const int rounds = options.rounds > 1 ? options.rounds + options.method.rounds.mending : 1;
  for (int round = 1; more && round < rounds; ++round) {
    log.start(fmt::format("round {}: partition", round + 1));
    more = move_interfaces(comm, dist, round, round < options.rounds ? never_free : GlobalId{0}, options.method.rounds);
    finish();
    if (!more) break;
    run_kernel(comm, dist, fmt::format("round {}: adapt", round + 1), log, [&] { return adapt_band(dist, local); });
  }
  log.start("balance");
  even_out(comm, dist, parts, options.method.rounds);
  finish();
  log.start("reconcile");
  for (VertState& s : dist.mesh.vert_state) s &= ~(kActive | kBesideFrozen | kRetry);
  reconcile(comm, dist, options.threads);
  finish();
}

}  // namespace skein
