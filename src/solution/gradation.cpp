// Gradation over the ranks: sizes by local fixpoints and minima at shared vertices, metrics by sweeps.
#include "solution/gradation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "dist/sharing.hpp"
#include "metric/gradation.hpp"

namespace skein {
namespace {

void require_growth(double growth) {
  if (growth > 1 && std::isfinite(growth)) return;
  throw Error(ExitCode::kInput,
              fmt::format("the gradation is {}; it must be greater than 1 (usual: 1.2 to 2)", growth));
}

/// What a neighbour demands of a vertex that other ranks have, too.
struct Demand {
  GlobalId vert, neighbour;
  SymTensor bound;
};

/// The sweeps over the metrics.
class MetricSweeps {
 public:
  MetricSweeps(const Comm& comm, const DistMesh& dist, double log_growth, std::span<SymTensor> metric)
      : comm_(comm),
        dist_(dist),
        log_growth_(log_growth),
        metric_(metric),
        graph_(vertex_graph(dist.mesh, dist.vert2gid)),
        shared_(dist.mesh.vert_slots(), -1),
        look_(dist.mesh.vert_slots(), 1),
        lowered_(dist.mesh.vert_slots(), 0) {
    for (std::size_t i = 0; i < dist.sharing.size(); ++i) shared_[dist.sharing.vert[i]] = static_cast<std::int32_t>(i);
  }

  /// Collective. True when something changed on any rank.
  bool sweep() {
    next_.clear(), dest_.clear(), send_.clear(), demands_.clear();
    collect();
    const auto got = exchange(comm_, std::span<const Rank>(dest_), std::span<const Demand>(send_));
    demands_.insert(demands_.end(), got.items.begin(), got.items.end());
    meet_shared();
    std::fill(look_.begin(), look_.end(), std::uint8_t{0});
    for (const auto& [v, m] : next_) {
      metric_[idx(v)] = m;
      lowered_[v] = 1;
      for (const VertId w : graph_.of(v)) look_[w] = 1;
    }
    return comm_.max(static_cast<std::int32_t>(next_.empty() ? 0 : 1)) != 0;
  }
  [[nodiscard]] const IdVector<VertId, std::uint8_t>& lowered() const noexcept { return lowered_; }

 private:
  [[nodiscard]] SymTensor bound(VertId from, VertId to) const noexcept {
    return grown(metric_[idx(from)], dist_.mesh.coords[to] - dist_.mesh.coords[from], log_growth_);
  }

  /// Inner vertices get their new metric; what is demanded of shared ones goes to all ranks that have them.
  void collect() {
    for (const VertId v : IdRange<VertId>(look_.size())) {
      if (look_[v] == 0) continue;
      const SymTensor& old = metric_[idx(v)];
      SymTensor m = old;
      bool changed = false;
      for (const VertId w : graph_.of(v)) {
        const SymTensor b = bound(w, v);
        if (is_within(old, b)) continue;
        if (shared_[v] >= 0) {
          demand(v, {dist_.vert2gid[v], dist_.vert2gid[w], b});
        } else if (!is_within(m, b)) {
          m = intersect(m, b);
          changed = true;
        }
      }
      if (changed) next_.emplace_back(v, m);
    }
  }
  void demand(VertId v, const Demand& d) {
    demands_.push_back(d);
    for (const Rank r : dist_.sharing.others(static_cast<std::size_t>(shared_[v]))) {
      dest_.push_back(r);
      send_.push_back(d);
    }
  }
  /// The same on all ranks that have the vertex: they know the same demands, and take them in the same order. One along
  /// an edge that several ranks have comes several times, with the same bits.
  void meet_shared() {
    std::sort(demands_.begin(), demands_.end(), [](const Demand& a, const Demand& b) {
      return std::tie(a.vert, a.neighbour) < std::tie(b.vert, b.neighbour);
    });
    const auto& gids = dist_.sharing.gid;
    for (std::size_t i = 0; i < demands_.size();) {
      const auto place = std::lower_bound(gids.begin(), gids.end(), demands_[i].vert) - gids.begin();
      const VertId v = dist_.sharing.vert[place];
      SymTensor m = metric_[idx(v)];
      std::size_t k = i;
      for (; k < demands_.size() && demands_[k].vert == demands_[i].vert; ++k) {
        if (!is_within(m, demands_[k].bound)) m = intersect(m, demands_[k].bound);
      }
      next_.emplace_back(v, m);
      i = k;
    }
  }

  const Comm& comm_;
  const DistMesh& dist_;
  const double log_growth_;
  std::span<SymTensor> metric_;
  VertGraph graph_;
  IdVector<VertId, std::int32_t> shared_;  ///< place in dist.sharing, or -1
  IdVector<VertId, std::uint8_t> look_;    ///< a neighbour has changed
  IdVector<VertId, std::uint8_t> lowered_;
  std::vector<std::pair<VertId, SymTensor>> next_;  ///< after this sweep
  std::vector<Rank> dest_;
  std::vector<Demand> send_, demands_;
};

std::int64_t count_lowered(const Comm& comm, const DistMesh& dist, const IdVector<VertId, std::uint8_t>& lowered) {
  const auto owned = owned_verts(comm, dist);
  std::int64_t n = 0;
  for (const VertId v : IdRange<VertId>(lowered.size())) n += lowered[v] != 0 && owned[v] != 0 ? 1 : 0;
  return comm.sum(n);
}

}  // namespace

GradationReport grade_sizes(const Comm& comm, const DistMesh& dist, const Halo& halo, double growth,
                            std::span<double> size) {
  VertGraph graph;
  agree(comm, [&] {
    require_growth(growth);
    for (const VertId v : IdRange<VertId>(size.size())) {
      if (size[idx(v)] > 0 && std::isfinite(size[idx(v)])) continue;
      throw Error(ExitCode::kInput, fmt::format("the size at vertex {} is {}; sizes must be greater than zero",
                                                num(dist.vert2gid[v]) + 1, size[idx(v)]));
    }
    graph = vertex_graph(dist.mesh, dist.vert2gid);
  });
  GradationReport report;
  IdVector<VertId, std::uint8_t> lowered(size.size(), 0);
  std::vector<VertId> changed;
  for (const VertId v : IdRange<VertId>(size.size())) changed.push_back(v);
  // A round trip per rank that a path of growth crosses; each lowers some size to a value of finitely many.
  std::vector<double> before(dist.sharing.size());
  for (bool go_on = true; go_on;) {
    grade_sizes(graph, dist.mesh.coords, std::log(growth), size, changed);
    for (const VertId v : changed) lowered[v] = 1;
    changed.clear();
    for (std::size_t i = 0; i < before.size(); ++i) before[i] = size[idx(dist.sharing.vert[i])];
    halo.min(size);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const VertId v = dist.sharing.vert[i];
      if (size[idx(v)] == before[i]) continue;
      lowered[v] = 1;
      changed.push_back(v);
    }
    ++report.sweeps;
    go_on = comm.sum(static_cast<std::int64_t>(changed.size())) > 0;
  }
  report.lowered = count_lowered(comm, dist, lowered);
  return report;
}

GradationReport grade_metric(const Comm& comm, const DistMesh& dist, double growth, std::span<SymTensor> metric) {
  agree(comm, [&] {
    require_growth(growth);
    for (const VertId v : IdRange<VertId>(metric.size())) {
      if (is_finite(metric[idx(v)])) continue;
      throw Error(ExitCode::kInput, fmt::format("the metric at vertex {} is not finite", num(dist.vert2gid[v]) + 1));
    }
  });
  MetricSweeps sweeps(comm, dist, std::log(growth), metric);
  GradationReport report;
  report.converged = false;
  while (!report.converged && report.sweeps < kMostSweeps) {
    report.converged = !sweeps.sweep();
    ++report.sweeps;
  }
  report.lowered = count_lowered(comm, dist, sweeps.lowered());
  return report;
}

}  // namespace skein
