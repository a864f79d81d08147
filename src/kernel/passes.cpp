// The passes of the kernel over one part.
#include "kernel/passes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace skein {
namespace {

constexpr std::size_t kAhead = 2;  ///< moves between asking for data and using them
constexpr int kTetsAhead = 16;     ///< the same for the tetrahedra of a sweep
constexpr unsigned kFetching = kSwapPass | kInsertPass | kCollapsePass;  ///< sweeps that read the neighbours
constexpr std::size_t kAlsoWhatIsAdded = ~std::size_t{0};
constexpr std::size_t kIndexShare = 8;  ///< from one vertex in so many on, all balls are found at once
/// Sweeps of each pass; guards, since each sweep looks only at what the one before has changed.
constexpr int kInsertSweeps = 100, kCollapseSweeps = 10, kSwapSweeps = 4;
/// Where along a long edge a point is tried when another vertex is too near the place of unit steps.
constexpr std::array<double, 5> kOtherPlaces{0.5, 0.35, 0.65, 0.2, 0.8};

}  // namespace

Passes::Passes(Part& part)
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
    if (part_.mesh.tet_slots() > reorder_above()) order();
  }
}

std::size_t Passes::reorder_above() const noexcept {
  const Method::MainPasses& o = part_.options.method.main;
  return static_cast<std::size_t>(o.reorder_growth) * std::max(ordered_, static_cast<std::size_t>(o.reorder_least));
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

Passes::Outcome Passes::collapse_in(TetId t, double below, double max_length) {
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
  const Method::Collapse& o = part_.options.method.collapse;
  const KeepFloor objective{cube(o.floor), o.share};
  if (collapse_.collapse(from, to, t, max_length, objective) ||
      collapse_.collapse(to, from, t, max_length, objective)) {
    return Outcome::kDone;
  }
  if (gather_shell(part_.mesh, t, from, to, shell_)) mark_refused(part_, shell_);
  return Outcome::kInVain;
}

std::int64_t Passes::collapse_short(double below, double max_length) {
  const std::int64_t before = part_.counts.collapse;
  if (collapsed_below_ > 0 && below > collapsed_below_) {  // a higher bound: what was looked at counts anew
    for (auto& d : part_.dirty) d |= kCollapsePass;
  }
  collapsed_below_ = below;
  const auto wanted = [&](TetId t) { return part_.edges[t].may_be_short != 0; };
  sweep(kCollapsePass, kCollapseSweeps, wanted, [&](TetId t) { collapse_in(t, below, max_length); });
  return part_.counts.collapse - before;
}

std::size_t Passes::list_long(TetId t, unsigned mask, double above, std::array<LongEdge, 6>& out) const {
  std::size_t n = 0;
  measure(part_, part_.mesh.tet2vert[t], mask, [&](std::size_t, VertId a, VertId b, double la, double lb) {
    const double l = log_mean(la, lb);
    if (l <= above) return;
    std::size_t at = n++;
    for (; at > 0 && out[at - 1].length < l; --at) out[at] = out[at - 1];
    out[at] = {l, lb / la, a, b};
  });
  return n;
}

InsertResult Passes::split_edge(TetId t, const LongEdge& edge, Places places) {
  const auto& [l, r, a, b] = edge;
  // Unit steps: of n pieces, the one in the middle ends the first half. With sizes that change geometrically along
  // the edge, s is the parameter of the metric fraction f.
  const double n = std::max(2.0, std::round(l));
  const double f = std::floor(n / 2) / n;
  double s = f;
  if (std::abs(r - 1) > 1e-3) s = std::log(1 + f * (r - 1)) / std::log(r);
  s = std::clamp(s, 0.1, 0.9);
  InsertResult done = insert_.on_edge(t, a, b, s);
  if (places == Places::kUnitSteps) return done;
  for (std::size_t k = 0; done == InsertResult::kTooClose && k < kOtherPlaces.size(); ++k) {
    done = insert_.on_edge(t, a, b, kOtherPlaces[k]);
  }
  return done;
}

Passes::Outcome Passes::split_in(TetId t, double above, Places places) {
  std::array<LongEdge, 6> edges;
  const unsigned all = part_.edges[t].may_be_long, mask = all & ~static_cast<unsigned>(part_.refused[t]);
  const std::size_t n = list_long(t, mask, above, edges);
  for (std::size_t i = 0; i < n; ++i) {
    if (!part_.mesh.has(edges[i].a, kActive) && !part_.mesh.has(edges[i].b, kActive)) continue;
    if (split_edge(t, edges[i], places) == InsertResult::kDone) return Outcome::kDone;
    mark_refused(part_, insert_.shell());
  }
  return n == 0 && mask == all ? Outcome::kNothingToDo : Outcome::kInVain;
}

void Passes::centroid_in(TetId t, double above) {
  bool is_long = false;
  measure(part_, part_.mesh.tet2vert[t], part_.edges[t].may_be_long,
          [&](std::size_t, VertId, VertId, double la, double lb) { is_long = is_long || log_mean(la, lb) > above; });
  if (!is_long) return;
  if (insert_.inside(t, {0.25, 0.25, 0.25, 0.25}, part_.closest_new) == InsertResult::kDone) return;
  // The boundary is refined along its edges, and what centroids cannot reach.
  split_in(t, above, Places::kUnitSteps);
}

void Passes::create_point_in(TetId t, double above) {
  const Method& o = part_.options.method;
  // In needles the distance to what is near cannot be seen from the cavity: better connected first.
  if (static_cast<double>(part_.q3[t]) < cube(o.insert.needle) && swap_.any(t, RaiseWorst{o.swap.gain})) return;
  if (o.points == PointCreation::kCentroids) {
    centroid_in(t, above);
  } else {
    split_in(t, above, Places::kUnitSteps);
  }
}

std::int64_t Passes::create_points(double times) {
  const Method::Lengths& o = part_.options.method.lengths;
  const std::int64_t before = part_.counts.insert;
  if (expected_ < 0) {
    expected_ = expected_points(part_.mesh);
    reserve(part_, static_cast<std::size_t>(expected_));
  }
  const std::int64_t enough = before + o.runaway * expected_;
  const auto wanted = [&](TetId t) { return part_.edges[t].may_be_long != 0; };
  const double above = times * o.split_above;
  part_.closest_new = times * o.closest_new;
  sweep(kInsertPass, kInsertSweeps, wanted, [&](TetId t) {
    if (part_.counts.insert <= enough) create_point_in(t, above);
  });
  part_.closest_new = o.closest_new;
  return part_.counts.insert - before;
}

std::int64_t Passes::create_coarse_points() {
  const std::int64_t created = create_points(part_.options.method.lengths.first_step);
  for (auto& d : part_.dirty) d = static_cast<std::uint8_t>(d | ((d & kToImprove) != 0 ? kInsertPass : 0));
  return created;
}

std::int64_t Passes::swap_below(double quality) {
  const Method::Swap& o = part_.options.method.swap;
  const std::int64_t before = part_.counts.swap;
  const RaiseWorst objective{o.gain};
  const auto limit = static_cast<float>(cube(quality)), any_ring = static_cast<float>(cube(o.any_ring_below));
  const auto wanted = [&](TetId t) { return part_.q3[t] < limit; };
  sweep(kSwapPass, kSwapSweeps, wanted, [&](TetId t) {
    const int ring = part_.q3[t] < any_ring ? Swapper::kMaxRing : o.quick_ring;
    swap_.any_edge(t, objective, ring, Swapper::Try::kNotRefused);
  });
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
    smooth_.move(to_move_[i], SmoothBall{});
  }
  smooth_.drop_index();
  return part_.counts.smooth - before;
}

bool Passes::is_off_surface(VertId v) const {
  constexpr double kOff = 1e-6;  // metric length
  const TetMesh& m = part_.mesh;
  if (m.surface_place[v] == SurfacePlace::kUnknown || m.has(v, kStays)) return false;
  const double off = part_.geometry->distance(m, v);
  const SymTensor& metric = m.metric[v].m;
  return off > 0 && off * off * (metric.xx + metric.yy + metric.zz) > kOff * kOff;
}

std::int64_t Passes::snap_to_surface() {
  const TetMesh& m = part_.mesh;
  if (m.surface_place.empty() || !part_.options.may_change_surface()) return 0;
  const Method::Snap& o = part_.options.method.snap;
  to_move_.clear();
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (m.is_live(v) && m.has(v, kActive) && !m.has(v, kFrozen) && is_off_surface(v)) to_move_.push_back(v);
  }
  for (int sweep = 0; sweep < o.sweeps && !to_move_.empty(); ++sweep) {
    for (const VertId v : to_move_) smooth_.move(v, ToSurface{cube(o.floor), o.share});
    std::erase_if(to_move_, [&](VertId v) { return !is_off_surface(v); });
  }
  return std::ssize(to_move_);
}

bool Passes::improve_lengths_in(TetId t, const Method::LengthBounds& bounds) {
  part_.dirty[t] = static_cast<std::uint8_t>(part_.dirty[t] & ~kInsertPass);
  if ((part_.edges[t].may_be_long | part_.edges[t].may_be_short) == 0) return false;
  if (!part_.mesh.is_live(t) || !part_.active(t)) return false;
  const Outcome split = split_in(t, bounds.longest, Places::kMany);
  if (split == Outcome::kDone) return true;
  const Outcome collapse = collapse_in(t, bounds.shortest, bounds.longest_new);
  if (collapse == Outcome::kDone) return true;
  if (split == Outcome::kInVain || collapse == Outcome::kInVain) part_.dirty[t] |= kInsertPass;
  return false;
}

void Passes::improve_lengths(const Method::LengthBounds& bounds, Where where) {
  part_.closest_new = bounds.closest_new;
  insert_.set_floor(Inserter::Floor::kStrict);
  const bool wider = bounds.longest >= improved_above_ && bounds.shortest <= improved_below_;
  improved_above_ = bounds.longest, improved_below_ = bounds.shortest;
  unsigned looked_at = where == Where::kDirty || wider ? kInsertPass : kToImprove;
  for (int turn = 0; turn < part_.options.method.improve.length_turns; ++turn) {
    bool any = false;
    forget_refused();
    for_each_dirty(part_, looked_at, kAlsoWhatIsAdded, [&](TetId t) { any = improve_lengths_in(t, bounds) || any; });
    if (!any) break;
    looked_at = kInsertPass;
  }
  part_.closest_new = part_.options.method.lengths.closest_new;
  insert_.set_floor(Inserter::Floor::kLoose);
}

}  // namespace skein
