// The passes of the kernel over one part.
#include "kernel/passes.hpp"

#include <algorithm>
#include <cmath>

#include "kernel/cavity.hpp"
#include "kernel/collapse.hpp"
#include "kernel/insert.hpp"
#include "kernel/smooth.hpp"
#include "kernel/swap.hpp"

namespace skein {
namespace {

constexpr double kFloor = 0.3 * 0.3 * 0.3;   ///< Q^3 that a collapse of a short edge must leave
constexpr double kHuntLength = 2;            ///< longest edge that may come of removing a vertex of a bad element
constexpr double kNeedle = 0.1 * 0.1 * 0.1;  ///< Q^3 below which an element is swapped before it gets points
constexpr double kPointsPerComplexity = 1.7;
constexpr std::int64_t kRunaway =
    4;  ///< times the expected points: what creates more does not fit its metric and must end
/// Vertices round an edge that is swapped in bulk: of 169,000 swaps 36 had more, and 6 were swaps of a face.
constexpr int kQuickRing = 4;
/// Below this quality an edge may have more vertices round it: where a metric turns and grows quickly over few elements
/// they make two points more of unit edges.
constexpr double kHardQuality = 0.45;
/// The main turns end when not more than one vertex in so many has come or gone.
constexpr std::int64_t kSettled = 20;
constexpr int kMostTurns = 5;
constexpr int kHuntTurns = 8, kHuntTries = 3;
constexpr std::size_t kIndexShare = 8;                ///< from one vertex in so many on, all balls are found at once
constexpr double kHuntLong = 1.8, kHuntShort = 0.55;  ///< edges that are hunted
constexpr double kHuntNewLength = 0.45;               ///< no new point closer than this then

constexpr double cube(double q) noexcept { return q * q * q; }

/// One worker's operators and its sweeps over what is dirty.
class Passes {
 public:
  explicit Passes(Part& part)
      : part_(part),
        cavity_(part),
        insert_(part, cavity_),
        collapse_(part, cavity_),
        swap_(part, cavity_),
        smooth_(part) {}

  std::int64_t collapse_short(double below, double max_length, double floor_q3);
  std::int64_t create_points();
  std::int64_t swap_below(double quality);
  std::int64_t smooth_below(double quality);
  /// The edges that the strict bounds have left far from unit length: bounds on what is made in their place are
  /// loosened.
  void hunt_lengths();
  /// Works on the elements below `target` with every operator, accepting only what makes the worst element better,
  /// until none can be improved.
  void hunt_worst(double target);

 private:
  /// A new sweep asks everywhere again.
  void forget_refused() { part_.refused.assign(part_.mesh.tet_slots(), 0); }
  /// Calls visit(t) for every live, active tetrahedron that is dirty for this pass and wanted(t), after taking the bit
  /// away, in up to `sweeps` sweeps, as long as there are any. `wanted` is asked first, so it should be cheap.
  template <class Wanted, class Visit>
  void sweep(Pass pass, int sweeps, Wanted&& wanted, Visit&& visit);
  bool collapse_in(TetId t, double below, double max_length, double floor_q3);
  /// Points that a unit mesh of the part would have.
  [[nodiscard]] std::int64_t expected_points() const;
  bool split_in(TetId t, double above);
  bool centroid_in(TetId t);
  /// Swaps one of the edges with at most max_ring vertices round it; refusals are remembered where the sweep is about
  /// swaps.
  bool swap_edges_in(TetId t, int max_ring, bool remember);
  bool swap_in(TetId t);
  bool smooth_in(TetId t);
  bool remove_vertex_in(TetId t);

  Part& part_;
  Cavity cavity_;
  Inserter insert_;
  Collapser collapse_;
  Swapper swap_;
  Smoother smooth_;
  Shell shell_;
  std::vector<VertId> to_move_;
  std::int64_t expected_ = -1;  ///< expected_points() before the first points
};

template <class Wanted, class Visit>
void Passes::sweep(Pass pass, int sweeps, Wanted&& wanted, Visit&& visit) {
  for (int s = 0; s < sweeps; ++s) {
    bool any = false;
    forget_refused();
    // The mesh may grow while this runs; what is added at the end belongs to this sweep.
    for (std::size_t i = 0; i < part_.mesh.tet_slots(); ++i) {
      const auto t = to_id<TetId>(i);
      if ((part_.dirty[t] & pass) == 0) continue;
      part_.dirty[t] = static_cast<std::uint8_t>(part_.dirty[t] & ~pass);
      if (!wanted(t) || !part_.mesh.is_live(t) || !part_.active(t)) continue;
      any = true;
      visit(t);
    }
    if (!any) return;
  }
}

/// The metric lengths of a tetrahedron's edges, as far as they matter: with la, lb the lengths in the metrics of its
/// ends, the logarithmic mean lies between sqrt(la lb) and sqrt((la^2 + lb^2)/2), which need no logarithm to tell that
/// an edge is fine.
struct EdgeLengths {
  std::array<double, 6> qa, qb;  ///< squares
  EdgeLengths(const Part& p, const std::array<VertId, 4>& v) noexcept {
    for (std::size_t e = 0; e < 6; ++e) {
      const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
      const Vec3 d = p.x(b) - p.x(a);
      qa[e] = quad(p.metric.at[a].m, d);
      qb[e] = quad(p.metric.at[b].m, d);
    }
  }
  [[nodiscard]] double length(std::size_t e) const noexcept { return log_mean(std::sqrt(qa[e]), std::sqrt(qb[e])); }
  /// The shortest edge if it is shorter than `below`, else 6.
  [[nodiscard]] std::size_t shortest(double below) const noexcept {
    std::size_t at = 6;
    double best = below;
    for (std::size_t e = 0; e < 6; ++e) {
      if (qa[e] * qb[e] >= best * best * best * best) continue;
      const double l = length(e);
      if (l < best) best = l, at = e;
    }
    return at;
  }
  /// Edges longer than `above`, longest first; their number.
  std::size_t longer(double above, std::array<std::pair<double, std::size_t>, 6>& out) const noexcept {
    std::size_t n = 0;
    for (std::size_t e = 0; e < 6; ++e) {
      if (qa[e] + qb[e] <= 2 * above * above) continue;
      const double l = length(e);
      if (l <= above) continue;
      std::size_t at = n++;
      for (; at > 0 && out[at - 1].first < l; --at) out[at] = out[at - 1];
      out[at] = {l, e};
    }
    return n;
  }
};

bool Passes::collapse_in(TetId t, double below, double max_length, double floor_q3) {
  if ((part_.dirty[t] & kMayBeShort) == 0) return false;
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  const std::size_t e = len.shortest(below);
  if (e == 6) {
    if (below >= part_.options.collapse_below) part_.dirty[t] &= static_cast<std::uint8_t>(~kMayBeShort);
    return false;
  }
  const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
  if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) return false;
  if ((part_.refused[t] & (1U << e)) != 0) return false;
  if (collapse_.collapse(a, b, t, max_length, floor_q3) || collapse_.collapse(b, a, t, max_length, floor_q3))
    return true;
  if (gather_shell(part_.mesh, t, a, b, shell_)) mark_refused(part_, shell_);
  return false;
}

std::int64_t Passes::collapse_short(double below, double max_length, double floor_q3) {
  const std::int64_t before = part_.counts.collapse;
  const auto wanted = [&](TetId t) { return (part_.dirty[t] & kMayBeShort) != 0; };
  sweep(kCollapsePass, 10, wanted, [&](TetId t) { collapse_in(t, below, max_length, floor_q3); });
  return part_.counts.collapse - before;
}

bool Passes::split_in(TetId t, double above) {
  if ((part_.dirty[t] & kMayBeLong) == 0) return false;
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  std::array<std::pair<double, std::size_t>, 6> order;
  const std::size_t n_long = len.longer(above, order);
  if (n_long == 0 && above <= part_.options.split_above) part_.dirty[t] &= static_cast<std::uint8_t>(~kMayBeLong);
  for (std::size_t i = 0; i < n_long; ++i) {
    const double l = order[i].first;
    const std::size_t e = order[i].second;
    const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
    if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) continue;
    if ((part_.refused[t] & (1U << e)) != 0) continue;
    // Unit steps: of n pieces, the one in the middle ends the first half. With sizes that change geometrically along
    // the edge, s is the parameter of the metric fraction f.
    const double n = std::max(2.0, std::round(l));
    const double f = std::floor(n / 2) / n, r = std::sqrt(len.qb[e] / len.qa[e]);
    double s = f;
    if (std::abs(r - 1) > 1e-3) s = std::log(1 + f * (r - 1)) / std::log(r);
    s = std::clamp(s, 0.1, 0.9);
    if (insert_.on_edge(t, a, b, s) == InsertResult::kDone) return true;
    mark_refused(part_, insert_.shell());
  }
  return false;
}

bool Passes::centroid_in(TetId t) {
  const auto v = part_.mesh.tet2vert[t];
  std::array<std::pair<double, std::size_t>, 6> order;
  if (EdgeLengths(part_, v).longer(part_.options.split_above, order) == 0) return false;
  if (insert_.inside(t, {0.25, 0.25, 0.25, 0.25}, part_.options.length_min_new) == InsertResult::kDone) return true;
  return split_in(
      t, part_.options.split_above);  // the boundary is refined along its edges, and what centroids cannot reach
}

std::int64_t Passes::expected_points() const {
  double sum = 0;
  for (const TetId t : IdRange<TetId>(part_.mesh.tet_slots())) {
    if (!part_.mesh.is_live(t)) continue;
    double density = 0;
    for (const VertId v : part_.mesh.tet2vert[t]) density += part_.metric.at[v].sqrt_det / 4;
    sum += density * volume6(part_.mesh, t) / 6;
  }
  return static_cast<std::int64_t>(kPointsPerComplexity * sum) + 1000;
}

std::int64_t Passes::create_points() {
  const std::int64_t before = part_.counts.insert;
  if (expected_ < 0) {
    expected_ = expected_points();
    reserve(part_, static_cast<std::size_t>(expected_));
  }
  const std::int64_t enough = before + kRunaway * expected_;
  const auto wanted = [&](TetId t) { return (part_.dirty[t] & kMayBeLong) != 0; };
  sweep(kInsertPass, 100, wanted, [&](TetId t) {
    if (part_.counts.insert > enough) return;
    // In needles the distance to what is near cannot be seen from the cavity: better connected first.
    if (part_.q3[t] < kNeedle && swap_in(t)) return;
    part_.options.centroid_points ? centroid_in(t) : split_in(t, part_.options.split_above);
  });
  return part_.counts.insert - before;
}

bool Passes::swap_edges_in(TetId t, int max_ring, bool remember) {
  const auto v = part_.mesh.tet2vert[t];
  const unsigned skip = (remember ? part_.refused[t] : 0U) | (max_ring <= 4 ? large_rings(part_.mesh, t) : 0U);
  for (std::size_t e = 0; e < 6; ++e) {
    if ((skip & (1U << e)) != 0) continue;
    const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
    if (swap_.edge(t, a, b, max_ring)) return true;
    if (remember) mark_refused(part_, swap_.shell());
  }
  return false;
}

bool Passes::swap_in(TetId t) {
  if (swap_edges_in(t, Swapper::kMaxRing, false)) return true;
  for (int f = 0; f < 4; ++f) {
    if (swap_.face(make_face(t, f))) return true;
  }
  return false;
}

std::int64_t Passes::swap_below(double quality) {
  const std::int64_t before = part_.counts.swap;
  const auto limit = static_cast<float>(cube(quality)), hard = static_cast<float>(cube(kHardQuality));
  const auto wanted = [&](TetId t) { return part_.q3[t] < limit; };
  sweep(kSwapPass, 4, wanted,
        [&](TetId t) { swap_edges_in(t, part_.q3[t] < hard ? Swapper::kMaxRing : kQuickRing, true); });
  return part_.counts.swap - before;
}

std::int64_t Passes::smooth_below(double quality) {
  const std::int64_t before = part_.counts.smooth;
  const auto limit = static_cast<float>(cube(quality));
  const std::uint32_t stamp = ++part_.vert_stamp;
  to_move_.clear();
  const auto wanted = [&](TetId t) { return part_.q3[t] < limit; };
  sweep(kSmoothPass, 1, wanted, [&](TetId t) {
    for (const VertId v : part_.mesh.tet2vert[t]) {
      if (part_.vert_mark[v] == stamp || !part_.mesh.has(v, kActive)) continue;
      part_.vert_mark[v] = stamp;
      to_move_.push_back(v);
    }
  });
  if (kIndexShare * to_move_.size() > part_.mesh.vert_slots()) smooth_.index_balls();
  for (const VertId v : to_move_) smooth_.move(v);
  smooth_.drop_index();
  return part_.counts.smooth - before;
}

bool Passes::smooth_in(TetId t) {
  const auto tv = part_.mesh.tet2vert[t];
  bool moved = false;
  for (const VertId v : tv) {
    if (part_.mesh.has(v, kActive)) moved = smooth_.move(v, kHuntTries) || moved;
  }
  return moved;
}

bool Passes::remove_vertex_in(TetId t) {
  const auto tv = part_.mesh.tet2vert[t];
  for (const VertId v : tv) {
    if (!part_.mesh.has(v, kActive)) continue;
    for (const VertId u : tv) {
      if (u != v && collapse_.collapse_to_improve(v, u, t, kHuntLength)) return true;
    }
  }
  return false;
}

void Passes::hunt_lengths() {
  const KernelOptions strict = part_.options;
  part_.options.length_min_new = kHuntNewLength;
  forget_refused();
  for (std::size_t i = 0; i < part_.mesh.tet_slots(); ++i) {
    const auto t = to_id<TetId>(i);
    if (!part_.mesh.is_live(t) || !part_.active(t)) continue;
    if (!split_in(t, kHuntLong)) collapse_in(t, kHuntShort, kHuntLong, kFloor);
  }
  part_.options = strict;
}

void Passes::hunt_worst(double target) {
  const auto limit = static_cast<float>(cube(target));
  for (int turn = 0; turn < kHuntTurns; ++turn) {
    std::int64_t done = 0;
    forget_refused();
    for (std::size_t i = 0; i < part_.mesh.tet_slots(); ++i) {
      const auto t = to_id<TetId>(i);
      if (part_.q3[t] >= limit || !part_.mesh.is_live(t) || !part_.active(t)) continue;
      if (swap_in(t) || smooth_in(t) || remove_vertex_in(t)) ++done;
    }
    if (done == 0) return;
  }
}

}  // namespace

IdVector<VertId, VertId> adapt_part(Part& part) {
  Passes pass(part);
  const KernelOptions& o = part.options;
  pass.collapse_short(0.5 * o.collapse_below, o.split_above, kFloor);
  pass.collapse_short(o.collapse_below, o.split_above, kFloor);
  pass.create_points();
  auto old2new = compact(part);
  for (int i = 0; i < kMostTurns; ++i) {
    pass.swap_below(0.7);
    pass.smooth_below(0.9);
    std::int64_t changed = pass.collapse_short(o.collapse_below, o.split_above, kFloor);
    changed += pass.create_points();
    const auto verts = static_cast<std::int64_t>(part.mesh.vert_slots() - part.free_verts.size());
    if (i >= 1 && kSettled * changed <= verts) break;
  }
  pass.hunt_lengths();
  pass.swap_below(0.7);
  pass.smooth_below(0.75);
  pass.hunt_lengths();
  pass.hunt_worst(0.5);
  return old2new;
}

}  // namespace skein
