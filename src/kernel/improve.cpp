// Work on single elements and edges.
#include "kernel/improve.hpp"

#include <algorithm>

namespace skein {
namespace {

constexpr double kLongest = 2;       ///< edge that may come of removing a vertex of a bad element
constexpr double kVeryPoor = 0.35;   ///< quality below which steps along axes are tried
constexpr double kRelaxFloor = 0.4;  ///< quality below which no element gets worse when edges are relaxed
constexpr int kTries = 3;
/// Sweeps end when none finds anything better, after 41 at most in all cases seen; this is for what has not been seen.
constexpr int kMostSweeps = 500;

}  // namespace

void Improver::note_changes(Pass hunt) {
  auto& dirty = part_->dirty;
  if ((all_new_ & hunt) != 0) {
    all_new_ = static_cast<std::uint8_t>(all_new_ & ~hunt);
    for (auto& d : dirty) d = static_cast<std::uint8_t>(d & ~hunt);
    state_.assign(part_->mesh.vert_slots(), kChanged | kToMove);
    return;
  }
  state_.assign(part_->mesh.vert_slots(), 0);
  for_each_dirty(*part_, hunt, dirty.size(), [&](TetId t) {
    if (!part_->mesh.is_live(t)) return;
    const bool changed = (dirty[t] & kHasChanged) != 0;
    if (changed) dirty[t] = static_cast<std::uint8_t>(dirty[t] & ~hunt);
    for (const VertId v : part_->mesh.tet2vert[t]) state_[v] |= changed ? kChanged | kToMove : kToMove;
  });
}

void Improver::make_all_new() {
  if (!part_->options.only_retry) {
    all_new_ = kImprovement;
    return;
  }
  for (auto& d : part_->dirty) {
    if ((d & kToImprove) != 0) d |= kImprovement;
  }
}

bool Improver::take(TetId t, Pass hunt) noexcept {
  std::uint8_t& dirty = part_->dirty[t];
  const auto& v = part_->mesh.tet2vert[t];
  const bool is_new =
      (dirty & hunt) != 0 || ((state_[v[0]] | state_[v[1]] | state_[v[2]] | state_[v[3]]) & kChanged) != 0;
  dirty = static_cast<std::uint8_t>(dirty & ~hunt);
  return is_new;
}

template <class Work>
void Improver::sweep(Pass hunt, double target, Work&& work) {
  const auto limit = static_cast<float>(cube(target));
  for (int turn = 0; turn < kMostSweeps; ++turn) {
    bool any = false;
    part_->refused.assign(part_->mesh.tet_slots(), 0);
    note_changes(hunt);
    for (std::size_t i = 0; i < part_->mesh.tet_slots(); ++i) {
      const auto t = to_id<TetId>(i);
      if (part_->q3[t] >= limit || !part_->mesh.is_live(t) || !part_->active(t)) continue;
      if (take(t, hunt)) any = work(t) || any;
    }
    if (!any) return;
  }
}

bool Improver::smooth_in(TetId t) {
  const auto tv = part_->mesh.tet2vert[t];
  bool moved = false;
  for (const VertId v : tv) {
    if (part_->mesh.has(v, kActive)) moved = smooth_->move(v, kTries) || moved;
  }
  return moved;
}

bool Improver::move_along_axes_in(TetId t) {
  if (!part_->careful || part_->q3[t] >= static_cast<float>(cube(kVeryPoor))) return false;
  const auto tv = part_->mesh.tet2vert[t];
  bool moved = false;
  for (const VertId v : tv) moved = (part_->mesh.has(v, kActive) && smooth_->move_along_axes(v)) || moved;
  return moved;
}

bool Improver::remove_vertex_in(TetId t) {
  const auto tv = part_->mesh.tet2vert[t];
  for (const VertId v : tv) {
    if (!part_->mesh.has(v, kActive)) continue;
    for (const VertId u : tv) {
      if (u != v && collapse_->collapse_to_improve(v, u, t, kLongest)) return true;
    }
  }
  return false;
}

void Improver::worst(double target) {
  sweep(kWorstPass, target,
        [&](TetId t) { return swap_->any(t) || smooth_in(t) || move_along_axes_in(t) || remove_vertex_in(t); });
}

bool Improver::reduce_sum_in(TetId t, double floor_q3) {
  // Several poor elements share each edge and each vertex: both are tried once in a sweep.
  const auto tv = part_->mesh.tet2vert[t];
  for (std::size_t e = 0; e < 6; ++e) {
    if ((part_->refused[t] & (1U << e)) != 0) continue;
    const VertId a = tv[kEdgeVerts[e][0]], b = tv[kEdgeVerts[e][1]];
    if (part_->mesh.has(a, kFrozen) && part_->mesh.has(b, kFrozen)) continue;
    if (swap_->edge_to_reduce_sum(t, a, b, floor_q3)) return true;
    mark_refused(*part_, swap_->shell());
    if (part_->mesh.has(a, kActive) && collapse_->collapse_to_reduce_sum(a, b, t, kLongest, floor_q3)) return true;
    if (part_->mesh.has(b, kActive) && collapse_->collapse_to_reduce_sum(b, a, t, kLongest, floor_q3)) return true;
  }
  bool moved = false;
  for (const VertId v : tv) {
    if ((state_[v] & kToMove) == 0 || !part_->mesh.has(v, kActive)) continue;
    state_[v] = static_cast<std::uint8_t>(state_[v] & ~kToMove);
    moved = smooth_->move_to_reduce_sum(v, floor_q3) || moved;
  }
  return moved;
}

void Improver::reduce_sum(double target, double floor) {
  sweep(kSumPass, target, [&](TetId t) { return reduce_sum_in(t, cube(floor)); });
}

void Improver::judge_carefully(bool careful) {
  part_->careful = careful;
  for (const TetId t : IdRange<TetId>(part_->mesh.tet_slots())) {
    if (part_->mesh.is_live(t)) part_->q3[t] = static_cast<float>(quality_cubed(*part_, t));
  }
  make_all_new();
}

bool Improver::judge_few_carefully(double quality) {
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
  part_->careful = true;
  for (const TetId t : few_) part_->q3[t] = static_cast<float>(quality_cubed(*part_, t));
  return true;
}

void Improver::leave_few() {
  part_->careful = false;
  const auto judge = [&](TetId t) {
    if (part_->mesh.is_live(t)) part_->q3[t] = static_cast<float>(quality_cubed(*part_, t));
  };
  for (const TetId t : few_) judge(t);
  for_each_dirty(*part_, kMainPasses, part_->dirty.size(), judge);
}

bool Improver::relax_edge(TetId t, VertId a, VertId b) {
  constexpr double kLongestNew = 1.8, kFloor = cube(kRelaxFloor);
  if (!part_->mesh.has(a, kActive) && !part_->mesh.has(b, kActive)) return false;
  if (part_->length(a, b) < 1 && (collapse_->collapse_to_relax(a, b, t, kLongestNew, kFloor) ||
                                  collapse_->collapse_to_relax(b, a, t, kLongestNew, kFloor))) {
    return true;
  }
  if (swap_->edge_to_relax(t, a, b, kFloor)) return true;
  const bool moved = part_->mesh.has(a, kActive) && smooth_->move_to_relax(a, kFloor);
  return (part_->mesh.has(b, kActive) && smooth_->move_to_relax(b, kFloor)) || moved;
}

void Improver::relax(int turns) {
  for (int turn = 0; turn < turns; ++turn) {
    bool any = false;
    part_->refused.assign(part_->mesh.tet_slots(), 0);
    for (std::size_t i = 0; i < part_->mesh.tet_slots(); ++i) {
      const auto t = to_id<TetId>(i);
      const unsigned mask =
          (part_->edges[t].may_be_long | part_->edges[t].may_be_short) & ~static_cast<unsigned>(part_->refused[t]);
      if (mask == 0 || (part_->dirty[t] & kToImprove) == 0 || !part_->mesh.is_live(t) || !part_->active(t)) continue;
      const auto v = part_->mesh.tet2vert[t];
      bool done = false;
      measure(*part_, v, mask, [&](std::size_t, VertId a, VertId b, double la, double lb) {
        const double l = log_mean(la, lb);
        if (done || (l >= part_->options.collapse_below && l <= part_->options.split_above)) return;
        done = relax_edge(t, a, b);
        if (!done && gather_shell(part_->mesh, t, a, b, shell_)) mark_refused(*part_, shell_);
      });
      any = any || done;
    }
    if (!any) return;
  }
}

}  // namespace skein
