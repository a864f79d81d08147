// The passes of the kernel over one part.
#include "kernel/passes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "kernel/cavity.hpp"
#include "kernel/collapse.hpp"
#include "kernel/improve.hpp"
#include "kernel/insert.hpp"
#include "kernel/smooth.hpp"
#include "kernel/swap.hpp"

namespace skein {
namespace {

constexpr double kFloor = 0.3 * 0.3 * 0.3;   ///< Q^3 that a collapse of a short edge must leave
constexpr double kNeedle = 0.1 * 0.1 * 0.1;  ///< Q^3 below which an element is swapped before it gets points
constexpr std::int64_t kRunaway =
    4;  ///< times the expected points: what creates more does not fit its metric and must end
/// Vertices round an edge that is swapped in bulk: of 169,000 swaps 36 had more, and 6 were swaps of a face.
constexpr int kQuickRing = 4;
/// Below this quality an edge may have more vertices round it: where a metric turns and grows quickly over few elements
/// they make two points more of unit edges.
constexpr double kTurningQuality = 0.45;
/// The main turns end when not more than one vertex in so many has come or gone.
constexpr std::int64_t kSettled = 20;
constexpr int kMostTurns = 5;
/// A mesh that has grown by this factor is put in order again, if it is larger than the caches.
constexpr std::size_t kGrowth = 3, kSmallMesh = 50'000;
constexpr std::size_t kAhead = 2;  ///< moves between asking for data and using them
constexpr int kTetsAhead = 16;     ///< the same for the tetrahedra of a sweep
constexpr unsigned kFetching = kSwapPass | kInsertPass | kCollapsePass;  ///< sweeps that read the neighbours
constexpr int kLengthTurns = 4;
/// Where along a long edge a point is tried when another vertex is too near the place of unit steps.
constexpr std::array<double, 5> kOtherPlaces{0.5, 0.35, 0.65, 0.2, 0.8};
constexpr std::size_t kAlsoWhatIsAdded = ~std::size_t{0};
/// What another round shall look at if frozen vertices were in the way of this one.
constexpr double kBadQuality = 0.3, kBadLong = 2, kBadShort = 0.4;
constexpr std::size_t kIndexShare = 8;  ///< from one vertex in so many on, all balls are found at once

/// One worker's operators and its sweeps over what is dirty.
class Passes {
 public:
  explicit Passes(Part& part)
      : part_(part),
        cavity_(part),
        insert_(part, cavity_),
        collapse_(part, cavity_),
        swap_(part, cavity_),
        smooth_(part),
        improve_(part, collapse_, swap_, smooth_),
        old2new_(part.mesh.vert_slots()),
        ordered_(part.mesh.tet_slots()) {
    for (const VertId v : IdRange<VertId>(old2new_.size())) old2new_[v] = part.mesh.is_live(v) ? v : kNoVert;
  }

  std::int64_t collapse_short(double below, double max_length, double floor_q3);
  /// Along edges longer than `times` split_above.
  std::int64_t create_points(double times = 1);
  /// Along edges longer than kCoarse split_above, as a first step: what is shorter is left to the next one.
  std::int64_t create_coarse_points();
  std::int64_t swap_below(double quality);
  std::int64_t smooth_below(double quality);
  /// Bounds for edges that the passes have left far from unit length.
  struct LengthBounds {
    double longest, shortest;  ///< edges beyond are hunted
    double max_new, min_new;   ///< looser than in the passes: bounds on what is made in their place
  };
  /// `only_new`: in elements that are dirty.
  void improve_lengths(const LengthBounds& hunt, bool only_new = false);
  /// Share of the elements that are below this quality.
  [[nodiscard]] double share_below(double quality) const;
  /// Share of the edges, as the tetrahedra meet them, that are too long or too short.
  [[nodiscard]] double strained_share() const;
  /// From now on metrics at vertices that move are interpolated from where they are now (TetMesh::anchor).
  void anchor();
  /// Counts what is still below `target`, by what holds it (OperationCounts).
  void count_poor(double target);
  /// kRetry on the vertices of what is far from what was wanted and is confined, as another round might do better
  /// there; kBesideFrozen on those of what is not good and has a bound vertex; and on no others.
  void mark_retry();
  /// Puts what is near in space near in memory, if much is new.
  void order_if_grown();
  [[nodiscard]] Improver& hunt() noexcept { return improve_; }
  /// Vertices before the first pass -> vertices now.
  [[nodiscard]] IdVector<VertId, VertId>& old2new() noexcept { return old2new_; }

 private:
  /// A new sweep asks everywhere again.
  void forget_refused() { part_.refused.assign(part_.mesh.tet_slots(), 0); }
  /// Calls visit(t) for every live, active tetrahedron that is dirty for this pass and wanted(t), after taking the bit
  /// away, in up to `sweeps` sweeps, as long as there are any. `wanted` is asked first, so it should be cheap.
  template <class Wanted, class Visit>
  void sweep(Pass pass, int sweeps, Wanted&& wanted, Visit&& visit);
  void order();
  /// Asks for the tetrahedra round t, which a look at its rings will read.
  void fetch_neighbours(TetId t) const noexcept;
  enum class Outcome { kNothingToDo, kInVain, kDone };
  Outcome collapse_in(TetId t, double below, double max_length, double floor_q3);
  /// Splits the longest of the edges above this length that can be; `hunt`: with more than one place for the point.
  Outcome split_in(TetId t, double above, bool hunt = false);
  void centroid_in(TetId t, double above);
  [[nodiscard]] bool is_bad(TetId t) const noexcept;
  /// Cannot be worked with. Where only what was held is worked on, idle vertices do not count: they have had a round
  /// with nothing in their way, and would hand each other on for ever.
  [[nodiscard]] bool is_bound(VertId v) const noexcept {
    const VertState f = part_.mesh.vert_state[v] & (kFrozen | kActive);
    return part_.options.only_retry ? f == (kFrozen | kActive) : f != kActive;
  }

  Part& part_;
  Cavity cavity_;
  Inserter insert_;
  Collapser collapse_;
  Swapper swap_;
  Smoother smooth_;
  Improver improve_;
  Shell shell_;
  std::vector<VertId> to_move_;
  IdVector<VertId, VertId> old2new_;
  std::size_t ordered_;  ///< tetrahedra when they were put in order
  double collapsed_below_ = 0;
  /// Bounds of the last hunt for lengths. What has changed since or was tried in vain has the bit kInsertPass.
  double improved_above_ = 0, improved_below_ = 0;
  std::int64_t expected_ = -1;  ///< expected_points() before the first points
};

// Inlined, since a function that only asks for data counts as one without effect.
[[gnu::always_inline]] inline void Passes::fetch_neighbours(TetId t) const noexcept {
  for (const FaceId f : part_.mesh.tet2face[t]) {
    const TetId nb = f == kNoFace ? t : face_tet(f);
    __builtin_prefetch(&part_.mesh.tet2vert[nb]);
    __builtin_prefetch(&part_.mesh.tet2face[nb]);
  }
  for (const VertId v : part_.mesh.tet2vert[t]) {
    if (v == kNoVert) return;
    __builtin_prefetch(&part_.mesh.metric[v]);
    __builtin_prefetch(&part_.mesh.coords[v]);
  }
}

template <class Wanted, class Visit>
void Passes::sweep(Pass pass, int sweeps, Wanted&& wanted, Visit&& visit) {
  for (int s = 0; s < sweeps; ++s) {
    bool any = false;
    forget_refused();
    // The mesh may grow while this runs; what is added at the end belongs to the next sweep.
    for_each_dirty(part_, pass, part_.mesh.tet_slots(), [&](TetId t) {
      part_.dirty[t] = static_cast<std::uint8_t>(part_.dirty[t] & ~pass);
      const TetId ahead{num(t) + kTetsAhead};
      if ((pass & kFetching) != 0 && idx(ahead) < part_.mesh.tet_slots() && wanted(ahead)) fetch_neighbours(ahead);
      if (!wanted(t) || !part_.mesh.is_live(t) || !part_.active(t)) return;
      any = true;
      visit(t);
    });
    if (!any) return;
    if (part_.mesh.tet_slots() > kGrowth * std::max(ordered_, kSmallMesh)) order();
  }
}

void Passes::order_if_grown() {
  if (part_.mesh.tet_slots() > ordered_ + ordered_ / 4) order();
}

void Passes::order() {
  const auto step = compact(part_);
  for (VertId& v : old2new_) {
    if (v != kNoVert) v = step[v];
  }
  ordered_ = part_.mesh.tet_slots();
}

Passes::Outcome Passes::collapse_in(TetId t, double below, double max_length, double floor_q3) {
  const auto v = part_.mesh.tet2vert[t];
  std::size_t edge = 6;
  VertId from = kNoVert, to = kNoVert;
  double shortest = below;
  measure(part_, v, part_.edges[t].may_be_short, [&](std::size_t e, VertId a, VertId b, double la, double lb) {
    const double l = log_mean(la, lb);
    if (l < shortest) shortest = l, edge = e, from = a, to = b;
  });
  if (edge == 6) return Outcome::kNothingToDo;
  if ((part_.refused[t] & (1U << edge)) != 0) return Outcome::kInVain;
  if (!part_.mesh.has(from, kActive) && !part_.mesh.has(to, kActive)) return Outcome::kInVain;
  if (collapse_.collapse(from, to, t, max_length, floor_q3) || collapse_.collapse(to, from, t, max_length, floor_q3)) {
    return Outcome::kDone;
  }
  if (gather_shell(part_.mesh, t, from, to, shell_)) mark_refused(part_, shell_);
  return Outcome::kInVain;
}

std::int64_t Passes::collapse_short(double below, double max_length, double floor_q3) {
  const std::int64_t before = part_.counts.collapse;
  if (collapsed_below_ > 0 && below > collapsed_below_) {  // a higher bound: what was looked at counts anew
    for (auto& d : part_.dirty) d |= kCollapsePass;
  }
  collapsed_below_ = below;
  const auto wanted = [&](TetId t) { return part_.edges[t].may_be_short != 0; };
  sweep(kCollapsePass, 10, wanted, [&](TetId t) { collapse_in(t, below, max_length, floor_q3); });
  return part_.counts.collapse - before;
}

Passes::Outcome Passes::split_in(TetId t, double above, bool hunt) {
  struct Long {
    double length, ratio;  ///< ratio of the lengths in the metrics of b and a
    VertId a, b;
  };
  std::array<Long, 6> order;
  std::size_t n_long = 0;
  const auto v = part_.mesh.tet2vert[t];
  const unsigned all = part_.edges[t].may_be_long, mask = all & ~static_cast<unsigned>(part_.refused[t]);
  measure(part_, v, mask, [&](std::size_t, VertId a, VertId b, double la, double lb) {
    const double l = log_mean(la, lb);
    if (l <= above) return;
    std::size_t at = n_long++;
    for (; at > 0 && order[at - 1].length < l; --at) order[at] = order[at - 1];
    order[at] = {l, lb / la, a, b};
  });
  for (std::size_t i = 0; i < n_long; ++i) {
    const auto& [l, r, a, b] = order[i];
    if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) continue;
    // Unit steps: of n pieces, the one in the middle ends the first half. With sizes that change geometrically along
    // the edge, s is the parameter of the metric fraction f.
    const double n = std::max(2.0, std::round(l));
    const double f = std::floor(n / 2) / n;
    double s = f;
    if (std::abs(r - 1) > 1e-3) s = std::log(1 + f * (r - 1)) / std::log(r);
    s = std::clamp(s, 0.1, 0.9);
    InsertResult done = insert_.on_edge(t, a, b, s);
    for (std::size_t k = 0; hunt && done == InsertResult::kTooClose && k < kOtherPlaces.size(); ++k) {
      done = insert_.on_edge(t, a, b, kOtherPlaces[k]);
    }
    if (done == InsertResult::kDone) return Outcome::kDone;
    mark_refused(part_, insert_.shell());
  }
  return n_long == 0 && mask == all ? Outcome::kNothingToDo : Outcome::kInVain;
}

void Passes::centroid_in(TetId t, double above) {
  bool is_long = false;
  measure(part_, part_.mesh.tet2vert[t], part_.edges[t].may_be_long,
          [&](std::size_t, VertId, VertId, double la, double lb) { is_long = is_long || log_mean(la, lb) > above; });
  if (!is_long) return;
  if (insert_.inside(t, {0.25, 0.25, 0.25, 0.25}, part_.options.length_min_new) == InsertResult::kDone) return;
  // The boundary is refined along its edges, and what centroids cannot reach.
  split_in(t, above);
}

std::int64_t Passes::create_points(double times) {
  const std::int64_t before = part_.counts.insert;
  if (expected_ < 0) {
    expected_ = expected_points(part_.mesh);
    reserve(part_, static_cast<std::size_t>(expected_));
  }
  const std::int64_t enough = before + kRunaway * expected_;
  const auto wanted = [&](TetId t) { return part_.edges[t].may_be_long != 0; };
  const double above = times * part_.options.split_above, min_new = part_.options.length_min_new;
  part_.options.length_min_new *= times;
  sweep(kInsertPass, 100, wanted, [&](TetId t) {
    if (part_.counts.insert > enough) return;
    // In needles the distance to what is near cannot be seen from the cavity: better connected first.
    if (part_.q3[t] < kNeedle && swap_.any(t)) return;
    if (part_.options.centroid_points) {
      centroid_in(t, above);
    } else {
      split_in(t, above);
    }
  });
  part_.options.length_min_new = min_new;
  return part_.counts.insert - before;
}

std::int64_t Passes::create_coarse_points() {
  const std::int64_t created = create_points(kCoarse);
  for (auto& d : part_.dirty) d = static_cast<std::uint8_t>(d | ((d & kToImprove) != 0 ? kInsertPass : 0));
  return created;
}

std::int64_t Passes::swap_below(double quality) {
  const std::int64_t before = part_.counts.swap;
  const auto limit = static_cast<float>(cube(quality)), hard = static_cast<float>(cube(kTurningQuality));
  const auto wanted = [&](TetId t) { return part_.q3[t] < limit; };
  sweep(kSwapPass, 4, wanted,
        [&](TetId t) { swap_.any_edge(t, part_.q3[t] < hard ? Swapper::kMaxRing : kQuickRing, true); });
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
  for (std::size_t i = 0; i < to_move_.size(); ++i) {
    smooth_.fetch_ball(to_move_[std::min(i + 2 * kAhead, to_move_.size() - 1)]);
    smooth_.fetch_vertices(to_move_[std::min(i + kAhead, to_move_.size() - 1)]);
    smooth_.move(to_move_[i]);
  }
  smooth_.drop_index();
  return part_.counts.smooth - before;
}

void Passes::improve_lengths(const LengthBounds& hunt, bool only_new) {
  const KernelOptions strict = part_.options;
  part_.options.length_min_new = hunt.min_new;
  insert_.set_strict(true);
  const bool wider = hunt.longest >= improved_above_ && hunt.shortest <= improved_below_;
  improved_above_ = hunt.longest, improved_below_ = hunt.shortest;
  unsigned looked_at = only_new || wider ? kInsertPass : kToImprove;
  for (int turn = 0; turn < kLengthTurns; ++turn) {
    bool any = false;
    forget_refused();
    for_each_dirty(part_, looked_at, kAlsoWhatIsAdded, [&](TetId t) {
      part_.dirty[t] = static_cast<std::uint8_t>(part_.dirty[t] & ~kInsertPass);
      if ((part_.edges[t].may_be_long | part_.edges[t].may_be_short) == 0) return;
      if (!part_.mesh.is_live(t) || !part_.active(t)) return;
      const Outcome split = split_in(t, hunt.longest, true);
      if (split == Outcome::kDone) {
        any = true;
        return;
      }
      const Outcome collapse = collapse_in(t, hunt.shortest, hunt.max_new, kFloor);
      any = any || collapse == Outcome::kDone;
      if (collapse != Outcome::kDone && (split == Outcome::kInVain || collapse == Outcome::kInVain))
        part_.dirty[t] |= kInsertPass;
    });
    if (!any) break;
    looked_at = kInsertPass;
  }
  part_.options = strict;
  insert_.set_strict(false);
}

double Passes::share_below(double quality) const {
  const auto limit = static_cast<float>(cube(quality));
  std::size_t live = 0, poor = 0;
  for (const TetId t : IdRange<TetId>(part_.mesh.tet_slots())) {
    if (!part_.mesh.is_live(t)) continue;
    ++live;
    poor += part_.q3[t] < limit ? 1 : 0;
  }
  return live == 0 ? 0 : static_cast<double>(poor) / static_cast<double>(live);
}

double Passes::strained_share() const {
  std::size_t seen = 0, strained = 0;
  for (const TetId t : IdRange<TetId>(part_.mesh.tet_slots())) {
    if (!part_.mesh.is_live(t)) continue;
    seen += 6;
    const unsigned mask = part_.edges[t].may_be_long | part_.edges[t].may_be_short;
    measure(part_, part_.mesh.tet2vert[t], mask, [&](std::size_t, VertId, VertId, double la, double lb) {
      const double l = log_mean(la, lb);
      strained += l < part_.options.collapse_below || l > part_.options.split_above ? 1 : 0;
    });
  }
  return seen == 0 ? 0 : static_cast<double>(strained) / static_cast<double>(seen);
}

void Passes::anchor() {
  part_.mesh.anchor.resize(part_.mesh.vert_slots());
  for (const VertId v : IdRange<VertId>(part_.mesh.vert_slots())) {
    part_.mesh.anchor[v] = {part_.mesh.coords[v], part_.mesh.log_metric[v]};
  }
}

void Passes::count_poor(double target) {
  const auto limit = static_cast<float>(cube(target));
  for (const TetId t : IdRange<TetId>(part_.mesh.tet_slots())) {
    if (part_.q3[t] >= limit || !part_.mesh.is_live(t) || !part_.active(t)) continue;
    OperationCounts& c = part_.counts;
    const bool boundary = part_.has_any(t, kSurface | kRidge | kCorner | kRequired);
    ++(part_.has_any(t, kFrozen) ? c.poor_at_interface : boundary ? c.poor_at_boundary : c.poor_inside);
  }
}

bool Passes::is_bad(TetId t) const noexcept {
  constexpr auto limit = static_cast<float>(cube(kBadQuality));
  if (part_.q3[t] < limit) return true;
  const EdgeBits bits = part_.edges[t];
  for (unsigned mask = bits.may_be_long | bits.may_be_short; mask != 0; mask &= mask - 1) {
    const auto& e = kEdgeVerts[std::countr_zero(mask)];
    const auto& tv = part_.mesh.tet2vert[t];
    const VertId a = tv[e[0]], b = tv[e[1]];
    if (part_.is_longer(a, b, kBadLong)) return true;
    // What is short after two rounds lies between vertices that must stay, as a rule, and costs elements, no accuracy.
    if (!part_.options.only_retry && part_.is_shorter(a, b, kBadShort)) return true;
  }
  return false;
}

void Passes::mark_retry() {
  TetMesh& m = part_.mesh;
  bool any = false;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    m.vert_state[v] &= ~(kRetry | kBesideFrozen);
    any = any || (is_bound(v) && m.is_live(v));
  }
  if (!any) return;
  // What has a tetrahedron with a bound vertex at one of its own is confined.
  const std::uint32_t stamp = ++part_.vert_stamp;
  constexpr auto good = static_cast<float>(cube(kGoodQuality));
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    const auto& tv = m.tet2vert[t];
    if (!is_bound(tv[0]) && !is_bound(tv[1]) && !is_bound(tv[2]) && !is_bound(tv[3])) continue;
    const VertState hindered = part_.q3[t] < good ? kBesideFrozen : VertState{};
    for (const VertId v : tv) {
      part_.vert_mark[v] = stamp;
      m.vert_state[v] |= hindered;
    }
  }
  const auto is_confined = [&](TetId t) {
    const auto& tv = m.tet2vert[t];
    return std::any_of(tv.begin(), tv.end(), [&](VertId v) { return part_.vert_mark[v] == stamp; });
  };
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t) || !is_confined(t) || !is_bad(t) || !part_.active(t)) continue;
    for (const VertId v : m.tet2vert[t]) m.vert_state[v] |= kRetry;
  }
}

}  // namespace

namespace {
/// How much work a mesh is worth. Removing vertices leaves worse elements than creating them, and far fewer; so a mesh
/// that has lost more vertices than it keeps gets more: unit edges 96.1 -> 97.6 %, mean quality 0.874 -> 0.882.
struct Care {
  double swap;     ///< elements below this quality are swapped
  double stretch;  ///< times split_above: the longest edge that removing a vertex may leave to be split again
};
/// A mesh with more poor elements than this after the main turns has a metric that turns within its elements (17 %
/// where h = 0.001 across a cylinder and 0.1 along it, below 3 % everywhere else): its edges are relaxed.
constexpr double kTurningShare = 0.05;
/// The same for elements below kBad: round a surface that stays, far coarser than the metric.
constexpr double kTurningShareOfBad = 0.01;
constexpr double kPoor = 0.5;  ///< quality below which elements are hunted
/// Quality below which elements are smoothed in the first of the main turns and in the others: between the two there is
/// much to move by then, and nothing to gain.
constexpr double kSmoothed = 0.9, kSmoothedAgain = 0.85;
/// Of such a mesh: with fewer strained edges than this it has been adapted to this metric before; with fewer than the
/// second and next to no bad elements the main turns would move much for little, and only single edges and elements are
/// worked on.
constexpr double kAdaptedBefore = 0.3, kSettledShare = 0.04, kFewBad = 0.0003;
constexpr double kBad = 0.2;  ///< quality below which an element is hunted carefully in any mesh
constexpr Care kRefined{.swap = 0.7, .stretch = 1}, kCoarsened{.swap = 0.8, .stretch = 1.03};
constexpr Passes::LengthBounds kFar{.longest = 1.8, .shortest = 0.55, .max_new = 1.8, .min_new = 0.45};
constexpr Passes::LengthBounds kVeryFar{.longest = 2.1, .shortest = 0.4, .max_new = 2.2, .min_new = 0.35};

/// The first step of halves; good places for the next one need good elements.
void create_coarse_points(Passes& pass, const Part& part, Care care) {
  if (kSettled * pass.create_coarse_points() <= part.live_verts()) return;
  pass.swap_below(care.swap);
  pass.smooth_below(kSmoothed);
}

/// Makes the part fit, but for single edges and elements.
Care main_turns(Passes& pass, Part& part) {
  const KernelOptions& o = part.options;
  // Much shorter ones first, where there may be many.
  if (!o.only_retry) pass.collapse_short(0.5 * o.collapse_below, o.split_above, kFloor);
  pass.collapse_short(o.collapse_below, o.split_above, kFloor);
  const Care care = part.counts.collapse > part.live_verts() ? kCoarsened : kRefined;
  if (!o.only_retry) create_coarse_points(pass, part, care);
  pass.create_points();
  pass.order_if_grown();
  for (int i = 0; i < kMostTurns; ++i) {
    pass.swap_below(care.swap);
    pass.smooth_below(i == 0 && !o.only_retry ? kSmoothed : kSmoothedAgain);
    std::int64_t changed = pass.collapse_short(o.collapse_below, care.stretch * o.split_above, kFloor);
    changed += pass.create_points();
    if (i + 1 >= o.least_turns && kSettled * changed <= part.live_verts()) break;
  }
  return care;
}

void hunt(Passes& pass, Care care, bool relax) {
  pass.improve_lengths(kFar);
  if (relax) pass.hunt().relax(1);
  pass.swap_below(care.swap);
  pass.smooth_below(0.75);
  pass.improve_lengths(kFar);
  pass.hunt().worst(kPoor);
  // Either may leave something for the other one; what has not changed is not looked at again.
  for (int i = 0; i < 2; ++i) {
    pass.improve_lengths(kVeryFar);
    pass.hunt().worst(0.4);
  }
}

/// The same where the metric turns within its elements.
void improve_turning(Passes& pass, Care care, bool settled) {
  constexpr int kRelaxTurns = 4, kPairs = 3;
  constexpr double kFewer = 0.4, kWorst = 0.39, kFloorOfWorst = 0.36;
  Improver& hunt = pass.hunt();
  hunt.judge_carefully(true);
  pass.improve_lengths(kVeryFar);
  hunt.relax(kRelaxTurns);
  if (!settled) {
    pass.swap_below(care.swap);
    pass.smooth_below(0.75);
  }
  hunt.reduce_sum(settled ? kFewer : kPoor, 0);
  hunt.relax(kRelaxTurns);
  hunt.reduce_sum(kFewer, 0);
  hunt.worst(kWorst);
  // In turns, since each of them leaves the other new places to go on from.
  for (int i = 0; i < kPairs; ++i) {
    hunt.reduce_sum(kWorst, kFloorOfWorst);
    hunt.worst(kWorst);
  }
  hunt.judge_carefully(false);
}
/// What is left between what must stay.
void improve_bad(Passes& pass) {
  constexpr double kFloorOfBad = 0.15, kPerhapsBad = 0.3;
  Improver& hunt = pass.hunt();
  if (!hunt.judge_few_carefully(kPerhapsBad)) return;
  hunt.reduce_sum(kBad, kFloorOfBad);
  hunt.worst(kBad);
  for (int i = 0; i < 2; ++i) {
    pass.improve_lengths(kVeryFar, true);
    hunt.worst(kBad);
  }
  hunt.leave_few();
}
}  // namespace

IdVector<VertId, VertId> adapt_part(Part& part) {
  Passes pass(part);
  const auto is_turning = [&] { return part.options.turning.value_or(pass.share_below(kPoor) > kTurningShare); };
  const double strained = is_turning() ? pass.strained_share() : 1;
  if (strained < kAdaptedBefore) pass.anchor();
  const bool settled = strained < kSettledShare && pass.share_below(kBadQuality) < kFewBad;
  const Care care = settled ? kRefined : main_turns(pass, part);
  part.turning = settled || is_turning() || (!part.options.turning && pass.share_below(kBad) > kTurningShareOfBad);
  if (part.turning) {
    improve_turning(pass, care, settled);
  } else {
    hunt(pass, care, part.options.relax);
    improve_bad(pass);
  }
  part.mesh.anchor = {};
  pass.count_poor(kPoor);
  pass.mark_retry();
  return std::move(pass.old2new());
}

IdVector<VertId, VertId> create_coarse_points(Part& part) {
  Passes pass(part);
  create_coarse_points(pass, part, kRefined);
  return std::move(pass.old2new());
}

}  // namespace skein
