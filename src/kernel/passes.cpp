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

 private:
  /// Calls visit(t) for every live, active tetrahedron that is dirty for this pass, after taking the bit away, in up to
  /// `sweeps` sweeps, as long as there are any.
  template <class Visit>
  void sweep(Pass pass, int sweeps, Visit&& visit);
  bool collapse_in(TetId t, double below, double max_length, double floor_q3);
  bool split_in(TetId t);
  bool centroid_in(TetId t);
  bool swap_in(TetId t);

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

/// Edges of a tetrahedron with their metric lengths.
struct EdgeLengths {
  std::array<double, 6> l;
  EdgeLengths(const Part& p, const std::array<VertId, 4>& v) noexcept {
    for (std::size_t e = 0; e < 6; ++e) {
      l[e] = p.length(v[static_cast<std::size_t>(kEdgeVerts[e][0])], v[static_cast<std::size_t>(kEdgeVerts[e][1])]);
    }
  }
};

bool Passes::collapse_in(TetId t, double below, double max_length, double floor_q3) {
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  const auto e = static_cast<std::size_t>(std::min_element(len.l.begin(), len.l.end()) - len.l.begin());
  if (len.l[e] >= below) return false;
  const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
  if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) return false;
  return collapse_.collapse(a, b, max_length, floor_q3) || collapse_.collapse(b, a, max_length, floor_q3);
}

std::int64_t Passes::collapse_short(double below, double max_length, double floor_q3) {
  const std::int64_t before = part_.counts.collapse;
  sweep(kCollapsePass, 10, [&](TetId t) { collapse_in(t, below, max_length, floor_q3); });
  return part_.counts.collapse - before;
}

bool Passes::split_in(TetId t) {
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  std::array<std::size_t, 6> order{0, 1, 2, 3, 4, 5};
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return len.l[i] > len.l[j]; });
  for (const std::size_t e : order) {
    const double l = len.l[e];
    if (l <= part_.options.split_above) return false;
    const VertId a = v[static_cast<std::size_t>(kEdgeVerts[e][0])], b = v[static_cast<std::size_t>(kEdgeVerts[e][1])];
    if (!part_.mesh.has(a, kActive) && !part_.mesh.has(b, kActive)) continue;
    // Unit steps: of n pieces, the one in the middle ends the first half.
    const double n = std::max(2.0, std::round(l));
    const double la = std::sqrt(quad(part_.metric.at[a].m, part_.x(b) - part_.x(a)));
    const double lb = std::sqrt(quad(part_.metric.at[b].m, part_.x(b) - part_.x(a)));
    // With sizes that change geometrically along the edge, the parameter of the metric fraction f.
    const double f = std::floor(n / 2) / n, r = lb / la;
    double s = f;
    if (std::abs(r - 1) > 1e-3) s = std::log(1 + f * (r - 1)) / std::log(r);
    s = std::clamp(s, 0.1, 0.9);
    if (insert_.on_edge(t, a, b, s) == InsertResult::kDone) return true;
  }
  return false;
}

bool Passes::centroid_in(TetId t) {
  const auto v = part_.mesh.tet2vert[t];
  const EdgeLengths len(part_, v);
  if (*std::max_element(len.l.begin(), len.l.end()) <= part_.options.split_above) return false;
  if (insert_.inside(t, {0.25, 0.25, 0.25, 0.25}, part_.options.length_min_new) == InsertResult::kDone) return true;
  return split_in(t);  // the boundary is refined along its edges, and what centroids cannot reach
}

std::int64_t Passes::create_points() {
  const std::int64_t before = part_.counts.insert;
  sweep(kInsertPass, 100, [&](TetId t) { part_.options.centroid_points ? centroid_in(t) : split_in(t); });
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

}  // namespace

void adapt_part(Part& part) {
  Passes pass(part);
  const KernelOptions& o = part.options;
  constexpr double kFloor = 0.3 * 0.3 * 0.3;
  pass.collapse_short(0.5 * o.collapse_below, o.split_above, kFloor);
  pass.collapse_short(o.collapse_below, o.split_above, kFloor);
  pass.create_points();
  for (int i = 0; i < 3; ++i) {
    pass.swap_below(i == 0 ? 0.6 : 0.75);
    pass.smooth_below(0.9);
    pass.collapse_short(o.collapse_below, o.split_above, kFloor);
    pass.create_points();
  }
  for (int i = 0; i < 4; ++i) {
    const auto swaps = pass.swap_below(0.8);
    const auto moves = pass.smooth_below(i < 2 ? 0.95 : 0.6);
    if (swaps + moves == 0) break;
  }
}

}  // namespace skein
