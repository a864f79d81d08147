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
constexpr int kHuntTurns = 8;
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
  /// Calls visit(t) for every live, active tetrahedron that is dirty for this pass, after taking the bit away, in up to
  /// `sweeps` sweeps, as long as there are any.
  template <class Visit>
  void sweep(Pass pass, int sweeps, Visit&& visit);
  bool collapse_in(TetId t, double below, double max_length, double floor_q3);
  /// Points that a unit mesh of the part would have.
  [[nodiscard]] std::int64_t expected_points() const;
  bool split_in(TetId t, double above);
  bool centroid_in(TetId t);
  bool swap_in(TetId t);
  bool smooth_in(TetId t);
  bool remove_vertex_in(TetId t);

  Part& part_;
  Cavity cavity_;
  Inserter insert_;
  Collapser collapse_;
  Swapper swap_;
  Smoother smooth_;
};

template <class Visit>
void Passes::sweep(Pass pass, int sweeps, Visit&& visit) {
  for (int s = 0; s < sweeps; ++s) {
    bool any = false;
    // The mesh may grow while this runs; what is added at the end belongs to this sweep.
    for (std::size_t i = 0; i < part_.mesh.tet_slots(); ++i) {
      const auto t = to_id<TetId>(i);
      if ((part_.dirty[t] & pass) == 0) continue;
      part_.dirty[t] = static_cast<std::uint8_t>(part_.dirty[t] & ~pass);
      if (!part_.mesh.is_live(t) || !part_.active(t)) continue;
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
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  const std::size_t e = len.shortest(below);
  if (e == 6) return false;
  const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
  if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) return false;
  return collapse_.collapse(a, b, max_length, floor_q3) || collapse_.collapse(b, a, max_length, floor_q3);
}

std::int64_t Passes::collapse_short(double below, double max_length, double floor_q3) {
  const std::int64_t before = part_.counts.collapse;
  sweep(kCollapsePass, 10, [&](TetId t) { collapse_in(t, below, max_length, floor_q3); });
  return part_.counts.collapse - before;
}

bool Passes::split_in(TetId t, double above) {
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  std::array<std::pair<double, std::size_t>, 6> order;
  const std::size_t n_long = len.longer(above, order);
  for (std::size_t i = 0; i < n_long; ++i) {
    const double l = order[i].first;
    const std::size_t e = order[i].second;
    const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
    if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) continue;
    // Unit steps: of n pieces, the one in the middle ends the first half. With sizes that change geometrically along
    // the edge, s is the parameter of the metric fraction f.
    const double n = std::max(2.0, std::round(l));
    const double f = std::floor(n / 2) / n, r = std::sqrt(len.qb[e] / len.qa[e]);
    double s = f;
    if (std::abs(r - 1) > 1e-3) s = std::log(1 + f * (r - 1)) / std::log(r);
    s = std::clamp(s, 0.1, 0.9);
    if (insert_.on_edge(t, a, b, s) == InsertResult::kDone) return true;
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
  const std::int64_t enough = before + kRunaway * expected_points();
  sweep(kInsertPass, 100, [&](TetId t) {
    if (part_.counts.insert > enough) return;
    // In needles the distance to what is near cannot be seen from the cavity: better connected first.
    if (part_.q3[t] < kNeedle && swap_in(t)) return;
    part_.options.centroid_points ? centroid_in(t) : split_in(t, part_.options.split_above);
  });
  return part_.counts.insert - before;
}

bool Passes::swap_in(TetId t) {
  const auto v = part_.mesh.tet2vert[t];
  for (const auto& e : kEdgeVerts) {
    if (swap_.edge(t, v[static_cast<std::size_t>(e[0])], v[static_cast<std::size_t>(e[1])])) return true;
  }
  for (int f = 0; f < 4; ++f) {
    if (swap_.face(make_face(t, f))) return true;
  }
  return false;
}

std::int64_t Passes::swap_below(double quality) {
  const std::int64_t before = part_.counts.swap;
  const auto limit = static_cast<float>(cube(quality));
  sweep(kSwapPass, 4, [&](TetId t) {
    if (part_.q3[t] < limit) swap_in(t);
  });
  return part_.counts.swap - before;
}

std::int64_t Passes::smooth_below(double quality) {
  const std::int64_t before = part_.counts.smooth;
  const auto limit = static_cast<float>(cube(quality));
  const std::uint32_t stamp = ++part_.vert_stamp;
  sweep(kSmoothPass, 1, [&](TetId t) {
    if (part_.q3[t] >= limit) return;
    const auto tv = part_.mesh.tet2vert[t];
    for (const VertId v : tv) {
      if (part_.vert_mark[v] == stamp || !part_.mesh.has(v, kActive)) continue;
      part_.vert_mark[v] = stamp;
      smooth_.move(v);
    }
  });
  return part_.counts.smooth - before;
}

bool Passes::smooth_in(TetId t) {
  const auto tv = part_.mesh.tet2vert[t];
  bool moved = false;
  for (const VertId v : tv) {
    if (part_.mesh.has(v, kActive)) moved = smooth_.move(v) || moved;
  }
  return moved;
}

bool Passes::remove_vertex_in(TetId t) {
  const auto tv = part_.mesh.tet2vert[t];
  for (const VertId v : tv) {
    if (!part_.mesh.has(v, kActive)) continue;
    for (const VertId u : tv) {
      if (u != v && collapse_.collapse_to_improve(v, u, kHuntLength)) return true;
    }
  }
  return false;
}

void Passes::hunt_lengths() {
  const KernelOptions strict = part_.options;
  part_.options.length_min_new = kHuntNewLength;
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
  for (const double smooth_limit : {0.9, 0.8}) {
    pass.swap_below(0.7);
    pass.smooth_below(smooth_limit);
    pass.collapse_short(o.collapse_below, o.split_above, kFloor);
    pass.create_points();
  }
  pass.hunt_lengths();
  for (int i = 0; i < 2; ++i) {
    pass.swap_below(0.7);
    pass.smooth_below(0.75);
  }
  pass.hunt_lengths();
  pass.hunt_worst(0.5);
  return old2new;
}

}  // namespace skein
