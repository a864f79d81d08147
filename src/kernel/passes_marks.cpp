// What the passes have left: shares, counts, and marks for the next round.
#include <algorithm>
#include <bit>

#include "kernel/passes.hpp"

namespace skein {

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
      strained +=
          l < part_.options.method.lengths.collapse_below || l > part_.options.method.lengths.split_above ? 1 : 0;
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
    const bool boundary = part_.has_any(t, kSurface | kRidge | kStays);
    ++(part_.has_any(t, kFrozen) ? c.poor_at_interface : boundary ? c.poor_at_boundary : c.poor_inside);
  }
}

bool Passes::is_bad(TetId t) const noexcept {
  const Method::Retry& o = part_.options.method.retry;
  if (part_.q3[t] < static_cast<float>(cube(o.bad_quality))) return true;
  const EdgeBits bits = part_.edges[t];
  for (unsigned mask = bits.may_be_long | bits.may_be_short; mask != 0; mask &= mask - 1) {
    const auto& e = kEdgeVerts[std::countr_zero(mask)];
    const auto& tv = part_.mesh.tet2vert[t];
    const VertId a = tv[e[0]], b = tv[e[1]];
    if (part_.is_longer(a, b, o.bad_long)) return true;
    // What is short after two rounds lies between vertices that must stay, as a rule, and costs elements, no accuracy.
    if (!part_.options.only_retry() && part_.is_shorter(a, b, o.bad_short)) return true;
  }
  return false;
}

bool Passes::unmark_retry() {
  TetMesh& m = part_.mesh;
  bool any = false;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    m.vert_state[v] &= ~(kRetry | kBesideFrozen);
    any = any || (is_bound(v) && m.is_live(v));
  }
  return any;
}

std::uint32_t Passes::mark_beside_bound() {
  TetMesh& m = part_.mesh;
  const std::uint32_t stamp = ++part_.vert_stamp;
  const auto good = static_cast<float>(cube(part_.options.method.retry.good_quality));
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    const auto& tv = m.tet2vert[t];
    if (!is_bound(tv[0]) && !is_bound(tv[1]) && !is_bound(tv[2]) && !is_bound(tv[3])) continue;
    const VertState poor = part_.q3[t] < good ? kBesideFrozen : VertState{};
    for (const VertId v : tv) {
      part_.vert_mark[v] = stamp;
      m.vert_state[v] |= poor;
    }
  }
  return stamp;
}

void Passes::mark_retry() {
  if (!unmark_retry()) return;
  // What has a tetrahedron with a bound vertex at one of its own is confined.
  TetMesh& m = part_.mesh;
  const std::uint32_t stamp = mark_beside_bound();
  const auto is_confined = [&](TetId t) {
    const auto& tv = m.tet2vert[t];
    return std::any_of(tv.begin(), tv.end(), [&](VertId v) { return part_.vert_mark[v] == stamp; });
  };
  // A vertex of the interface that is beside the surface comes onto it when it is free.
  const bool may_be_off = !m.surface_place.empty() && part_.options.may_change_surface();
  const auto is_off = [&](TetId t) {
    const auto& tv = m.tet2vert[t];
    return may_be_off && std::any_of(tv.begin(), tv.end(), [&](VertId v) { return is_off_surface(v); });
  };
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t) || !is_confined(t) || !part_.active(t) || !(is_bad(t) || is_off(t))) continue;
    for (const VertId v : m.tet2vert[t]) m.vert_state[v] |= kRetry;
  }
}

}  // namespace skein
