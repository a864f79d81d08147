// Sweeps over single elements and edges.
#include "kernel/improve.hpp"

#include <algorithm>

namespace skein {
void Improver::note_changes(Pass pass) {
  auto& dirty = part_->dirty;
  if ((all_new_ & pass) != 0) {
    all_new_ = static_cast<std::uint8_t>(all_new_ & ~pass);
    for (auto& d : dirty) d = static_cast<std::uint8_t>(d & ~pass);
    state_.assign(part_->mesh.vert_slots(), kChanged | kToMove);
    return;
  }
  state_.assign(part_->mesh.vert_slots(), 0);
  for_each_dirty(*part_, pass, dirty.size(), [&](TetId t) {
    if (!part_->mesh.is_live(t)) return;
    const bool changed = (dirty[t] & kHasChanged) != 0;
    if (changed) dirty[t] = static_cast<std::uint8_t>(dirty[t] & ~pass);
    for (const VertId v : part_->mesh.tet2vert[t]) state_[v] |= changed ? kChanged | kToMove : kToMove;
  });
}

void Improver::make_all_new() {
  if (!part_->options.only_retry()) {
    all_new_ = kImprovement;
    return;
  }
  for (auto& d : part_->dirty) {
    if ((d & kToImprove) != 0) d |= kImprovement;
  }
}

bool Improver::take(TetId t, Pass pass) noexcept {
  std::uint8_t& dirty = part_->dirty[t];
  const auto& v = part_->mesh.tet2vert[t];
  const bool is_new =
      (dirty & pass) != 0 || ((state_[v[0]] | state_[v[1]] | state_[v[2]] | state_[v[3]]) & kChanged) != 0;
  dirty = static_cast<std::uint8_t>(dirty & ~pass);
  return is_new;
}

template <class Work>
void Improver::sweep(Pass pass, double target, Work&& work) {
  const auto limit = static_cast<float>(cube(target));
  for (int turn = 0; turn < part_->options.method.improve.most_sweeps; ++turn) {
    bool any = false;
    part_->refused.assign(part_->mesh.tet_slots(), 0);
    note_changes(pass);
    for (std::size_t i = 0; i < part_->mesh.tet_slots(); ++i) {
      const auto t = to_id<TetId>(i);
      if (part_->q3[t] >= limit || !part_->mesh.is_live(t) || !part_->active(t)) continue;
      if (take(t, pass)) any = work(t) || any;
    }
    if (!any) return;
  }
}

bool Improver::smooth_in(TetId t) {
  const Method::Smooth& o = part_->options.method.smooth;
  const auto tv = part_->mesh.tet2vert[t];
  bool moved = false;
  for (const VertId v : tv) {
    if (part_->mesh.has(v, kActive)) moved = smooth_->move(v, SmoothBall{o.tries_of_poor}) || moved;
  }
  return moved;
}

bool Improver::move_along_axes_in(TetId t) {
  const Method::Improve& o = part_->options.method.improve;
  if (part_->quality_measure == QualityMeasure::kLargestMetric ||
      part_->q3[t] >= static_cast<float>(cube(o.axes_below)))
    return false;
  const auto tv = part_->mesh.tet2vert[t];
  bool moved = false;
  for (const VertId v : tv) moved = (part_->mesh.has(v, kActive) && smooth_->move(v, RaiseWorst{o.axes_gain})) || moved;
  return moved;
}

bool Improver::remove_vertex_in(TetId t) {
  const Method& o = part_->options.method;
  const auto tv = part_->mesh.tet2vert[t];
  for (const VertId v : tv) {
    if (!part_->mesh.has(v, kActive)) continue;
    for (const VertId u : tv) {
      if (u != v && collapse_->collapse(v, u, t, o.collapse.longest_of_poor, RaiseWorst{o.improve.worst_gain}))
        return true;
    }
  }
  return false;
}

void Improver::raise_worst(double target) {
  const RaiseWorst by_swap{part_->options.method.swap.gain};
  sweep(kWorstPass, target, [&](TetId t) {
    return swap_->any(t, by_swap) || smooth_in(t) || move_along_axes_in(t) || remove_vertex_in(t);
  });
}

bool Improver::lower_sum_in(TetId t, double floor_q3) {
  const Method& o = part_->options.method;
  const double longest = o.collapse.longest_of_poor;
  const LowerSum by_swap{floor_q3, o.sum.swap_share, o.sum.swap_floor_share},
      by_collapse{floor_q3, o.sum.collapse_share}, by_move{floor_q3, o.sum.move_share};
  // Several poor elements share each edge and each vertex: both are tried once in a sweep.
  const TetMesh& m = part_->mesh;
  const auto tv = m.tet2vert[t];
  for (std::size_t e = 0; e < 6; ++e) {
    if ((part_->refused[t] & (1U << e)) != 0) continue;
    const VertId a = tv[kEdgeVerts[e][0]], b = tv[kEdgeVerts[e][1]];
    if (m.has(a, kFrozen) && m.has(b, kFrozen)) continue;
    if (swap_->edge(t, a, b, by_swap)) return true;
    mark_refused(*part_, swap_->shell());
    if (m.has(a, kActive) && collapse_->collapse(a, b, t, longest, by_collapse)) return true;
    if (m.has(b, kActive) && collapse_->collapse(b, a, t, longest, by_collapse)) return true;
  }
  bool moved = false;
  for (const VertId v : tv) {
    if ((state_[v] & kToMove) == 0 || !m.has(v, kActive)) continue;
    state_[v] = static_cast<std::uint8_t>(state_[v] & ~kToMove);
    moved = smooth_->move(v, by_move) || moved;
  }
  return moved;
}

void Improver::lower_sum(double target, double floor) {
  sweep(kSumPass, target, [&](TetId t) { return lower_sum_in(t, cube(floor)); });
}

void Improver::set_measure(QualityMeasure measure) {
  part_->quality_measure = measure;
  for (const TetId t : IdRange<TetId>(part_->mesh.tet_slots())) {
    if (part_->mesh.is_live(t)) part_->q3[t] = static_cast<float>(quality_cubed(*part_, t));
  }
  make_all_new();
}

bool Improver::measure_few(double quality) {
  const auto limit = static_cast<float>(cube(quality));
  state_.assign(part_->mesh.vert_slots(), 0);
  few_.clear();
  const auto take = [&](TetId t) {
    if ((part_->dirty[t] & kImprovement) != 0) return;
    part_->dirty[t] |= kImprovement;
    few_.push_back(t);
  };
  for (auto& d : part_->dirty) d &= kToImprove | kHasChanged;
  all_new_ = 0;
  for (const TetId t : IdRange<TetId>(part_->mesh.tet_slots())) {
    if (part_->q3[t] >= limit || (part_->dirty[t] & kToImprove) == 0 || !part_->mesh.is_live(t)) continue;
    take(t);
    for (const VertId v : part_->mesh.tet2vert[t]) {
      ball_.clear();
      if (state_[v] != 0 || !gather_ball(*part_, v, ball_)) continue;
      state_[v] = kChanged;
      for (const TetId near : ball_) take(near);
    }
  }
  if (few_.empty()) return false;
  part_->quality_measure = QualityMeasure::kLeast;
  for (const TetId t : few_) part_->q3[t] = static_cast<float>(quality_cubed(*part_, t));
  return true;
}

void Improver::leave_few() {
  part_->quality_measure = QualityMeasure::kLargestMetric;
  const auto judge = [&](TetId t) {
    if (part_->mesh.is_live(t)) part_->q3[t] = static_cast<float>(quality_cubed(*part_, t));
  };
  for (const TetId t : few_) judge(t);
  for_each_dirty(*part_, kMainPasses, part_->dirty.size(), judge);
}

bool Improver::lower_strain_of(TetId t, VertId a, VertId b) {
  const Method::Strain& o = part_->options.method.strain;
  const double floor_q3 = cube(o.floor);
  const LowerStrain plain{floor_q3}, by_swap{floor_q3, o.swap_floor_share, o.swap_strain_share};
  const TetMesh& m = part_->mesh;
  if (!m.has(a, kActive) && !m.has(b, kActive)) return false;
  if (part_->length(a, b) < 1 &&
      (collapse_->collapse(a, b, t, o.longest_new, plain) || collapse_->collapse(b, a, t, o.longest_new, plain))) {
    return true;
  }
  if (swap_->edge(t, a, b, by_swap)) return true;
  const bool moved = m.has(a, kActive) && smooth_->move(a, plain);
  return (m.has(b, kActive) && smooth_->move(b, plain)) || moved;
}

bool Improver::lower_strain_in(TetId t) {
  const Method::Lengths& o = part_->options.method.lengths;
  const EdgeBits edges = part_->edges[t];
  const unsigned mask = (edges.may_be_long | edges.may_be_short) & ~static_cast<unsigned>(part_->refused[t]);
  if (mask == 0 || (part_->dirty[t] & kToImprove) == 0 || !part_->mesh.is_live(t) || !part_->active(t)) return false;
  const auto v = part_->mesh.tet2vert[t];
  bool done = false;
  measure(*part_, v, mask, [&](std::size_t, VertId a, VertId b, double la, double lb) {
    const double l = log_mean(la, lb);
    if (done || (l >= o.collapse_below && l <= o.split_above)) return;
    done = lower_strain_of(t, a, b);
    if (!done && gather_shell(part_->mesh, t, a, b, shell_)) mark_refused(*part_, shell_);
  });
  return done;
}

void Improver::lower_strain(int turns) {
  for (int turn = 0; turn < turns; ++turn) {
    bool any = false;
    part_->refused.assign(part_->mesh.tet_slots(), 0);
    for (std::size_t i = 0; i < part_->mesh.tet_slots(); ++i) any = lower_strain_in(to_id<TetId>(i)) || any;
    if (!any) return;
  }
}

}  // namespace skein
