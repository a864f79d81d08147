// Statistics of a distributed mesh: see the header.
#include "report/statistics.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "dist/rendezvous.hpp"
#include "metric/batch.hpp"
#include "metric/measure.hpp"
#include "report/element_pass.hpp"
#include "report/order_statistics.hpp"

namespace skein {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

IdVector<VertId, VertMetric> metrics(const DistMesh& dist, int threads) {
  const std::size_t n = dist.mesh.vert_slots();
  IdVector<VertId, VertMetric> m(n);
  in_parallel(threads, [&](int w) {
    vert_metrics_from_logs(
        share_begin(n, w, threads), share_begin(n, w + 1, threads),
        [&](std::size_t i) -> const SymTensor& { return dist.mesh.log_metric[to_id<VertId>(i)]; },
        [&](std::size_t i, const VertMetric& v) { m[to_id<VertId>(i)] = v; });
  });
  return m;
}

/// All tetrahedra, by threads whose sums are added in their order.
TetSums tet_pass(const TetMesh& m, const IdVector<VertId, VertMetric>* metric, std::span<double> quality, int threads) {
  std::vector<TetSums> sums(static_cast<std::size_t>(threads));
  const std::size_t n = m.tet_slots();
  in_parallel(threads, [&](int w) {
    sums[w] = element_pass(m, metric, share_begin(n, w, threads), share_begin(n, w + 1, threads), quality);
  });
  TetSums all;
  for (const TetSums& s : sums) all += s;
  return all;
}

/// Tetrahedra at each of the vertices [first, last), in one flat list.
struct Balls {
  std::size_t first;
  std::vector<std::uint32_t> offset;
  std::vector<TetId> tets;
  [[nodiscard]] std::span<const TetId> at(std::size_t v) const noexcept {
    return {tets.data() + offset[v - first], tets.data() + offset[v - first + 1]};
  }
};
Balls balls(const TetMesh& m, std::size_t first, std::size_t last) {
  Balls b{first, {}, {}};
  const std::size_t n = last - first;
  const auto place = [&](VertId v) { return idx(v) - first; };  // beyond n for others
  b.offset.assign(n + 2, 0);
  for (const auto& v : m.tet2vert) {
    for (const VertId a : v) {
      if (place(a) < n) ++b.offset[place(a) + 2];
    }
  }
  std::partial_sum(b.offset.begin(), b.offset.end(), b.offset.begin());
  b.tets.resize(b.offset.back());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (const VertId a : m.tet2vert[t]) {
      if (place(a) < n) b.tets[b.offset[place(a) + 1]++] = t;
    }
  }
  return b;
}

struct LocalEdge {
  VertId a, b;
};
struct EdgeKey {
  GlobalId a, b;  // a < b
  friend auto operator<=>(const EdgeKey&, const EdgeKey&) = default;
};

/// What one thread gathers over its edges.
struct EdgeSums {
  std::int64_t edges = 0;
  std::vector<double> lengths;
  std::vector<LocalEdge> shared;  // both ends on other ranks, too: counted by the one whom the rendezvous names
};

/// Pass over the edges whose lower end is one of the vertices [first, last), each once. Edges are collected first and
/// measured then: whether one has been met is as good as random, so neither asks with a branch.
EdgeSums edge_pass(const DistMesh& dist, const IdVector<VertId, VertMetric>* metric, const std::vector<char>& is_shared,
                   std::size_t first, std::size_t last) {
  constexpr std::size_t kEdgesPerVert = 7;  // a little more than there are
  const TetMesh& m = dist.mesh;
  const Balls ball = balls(m, first, last);
  EdgeSums s;
  if (metric != nullptr) s.lengths.reserve(kEdgesPerVert * (last - first));
  IdVector<VertId, VertId> seen_from(m.vert_slots(), kNoVert);
  std::vector<VertId> met;
  for (std::size_t i = first; i < last; ++i) {
    const auto a = to_id<VertId>(i);
    const auto tets = ball.at(i);
    if (met.size() < 4 * tets.size()) met.resize(4 * tets.size());
    std::size_t n = 0;
    for (const TetId t : tets) {
      for (const VertId b : m.tet2vert[t]) {
        met[n] = b;
        n += static_cast<std::size_t>(b > a) & static_cast<std::size_t>(seen_from[b] != a);
        seen_from[b] = a;
      }
    }
    if (is_shared[i] != 0) {
      const auto ours = std::partition(met.begin(), met.begin() + static_cast<std::ptrdiff_t>(n),
                                       [&](VertId b) { return is_shared[idx(b)] == 0; });
      const auto own = static_cast<std::size_t>(ours - met.begin());
      for (std::size_t k = own; k < n; ++k) s.shared.push_back({a, met[k]});
      n = own;
    }
    s.edges += static_cast<std::int64_t>(n);
    if (metric == nullptr) continue;
    const std::size_t before = s.lengths.size();
    s.lengths.resize(before + n);
    for (std::size_t k = 0; k < n; ++k) {
      const VertId b = met[k];
      s.lengths[before + k] = edge_length((*metric)[a].m, (*metric)[b].m, m.coords[b] - m.coords[a]);
    }
  }
  return s;
}

/// Collective. Which of the edges this rank is to count: 1 or 0 for each. Of several ranks the lowest counts it.
std::vector<char> mine_to_count(const Comm& comm, const DistMesh& dist, const std::vector<LocalEdge>& edges) {
  std::vector<EdgeKey> keys;
  std::vector<Rank> dest;
  for (const LocalEdge& e : edges) {
    const auto [a, b] = std::minmax(dist.vert2gid[e.a], dist.vert2gid[e.b]);
    keys.push_back({a, b});
    dest.push_back(meeting_rank(hash_of(std::array{a, b}), comm.size()));
  }
  const Packets<EdgeKey> sent = pack(std::span<const Rank>(dest), std::span<const EdgeKey>(keys));
  const Packets<EdgeKey> asked = exchange(comm, sent);
  std::vector<std::size_t> order(asked.items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    return asked.items[x] != asked.items[y] ? asked.items[x] < asked.items[y] : x < y;  // sources come ascending
  });
  std::vector<char> answer(order.size(), 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    answer[order[i]] = i == 0 || asked.items[order[i]] != asked.items[order[i - 1]];
  }
  // reply() answers in the order of the packets; pack() is stable, so the order per destination is that of `edges`
  const std::vector<char> packed = reply(comm, sent, asked, std::span<const char>(answer));
  std::vector<std::size_t> at(static_cast<std::size_t>(comm.size()), 0);
  for (std::size_t i = 0; i < sent.blocks(); ++i) at[idx(sent.rank[i])] = sent.offset[i];
  std::vector<char> mine(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) mine[i] = packed[at[idx(dest[i])]++];
  return mine;
}

/// What is known of the edges that this rank counts.
struct Edges {
  std::int64_t count = 0;
  std::vector<std::vector<double>> lengths;  ///< in pieces
};

/// Collective. All edges that this rank counts, and their lengths.
Edges edges_of(const Comm& comm, const DistMesh& dist, const IdVector<VertId, VertMetric>* metric, int threads) {
  std::vector<char> is_shared(dist.mesh.vert_slots(), 0);
  for (const VertId v : dist.sharing.vert) is_shared[idx(v)] = 1;
  std::vector<EdgeSums> sums(static_cast<std::size_t>(threads));
  const std::size_t n = dist.mesh.vert_slots();
  in_parallel(threads, [&](int w) {
    sums[w] = edge_pass(dist, metric, is_shared, share_begin(n, w, threads), share_begin(n, w + 1, threads));
  });
  Edges all;
  std::vector<LocalEdge> shared;
  for (EdgeSums& s : sums) {
    all.count += s.edges;
    all.lengths.push_back(std::move(s.lengths));
    shared.insert(shared.end(), s.shared.begin(), s.shared.end());
  }
  const std::vector<char> mine = mine_to_count(comm, dist, shared);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    if (mine[i] == 0) continue;
    const LocalEdge e = shared[i];
    ++all.count;
    if (metric != nullptr) {
      const Vec3 d = dist.mesh.coords[e.b] - dist.mesh.coords[e.a];
      all.lengths.back().push_back(edge_length((*metric)[e.a].m, (*metric)[e.b].m, d));
    }
  }
  return all;
}

struct Interval {
  double low, high;
};
/// What can be said of numbers in one pass; `bounds` are the inner ones of the histogram.
template <std::size_t kBounds>
struct Summary {
  double low = kInfinity, high = -kInfinity, sum = 0;
  std::int64_t inside = 0;  ///< in the interval, with its ends
  std::array<std::int64_t, kBounds + 1> histogram{};
};

/// Of the rank's numbers.
template <std::size_t kBounds>
Summary<kBounds> summary(Pieces values, const std::array<double, kBounds>& bounds, Interval inside) {
  std::vector<Summary<kBounds>> of_piece(values.size());
  in_parallel(static_cast<int>(values.size()), [&](int w) {
    Summary<kBounds> s;
    for (const double v : values[w]) {
      s.low = std::min(s.low, v), s.high = std::max(s.high, v), s.sum += v;
      std::size_t bin = 0;
      for (const double bound : bounds) bin += v >= bound ? 1 : 0;
      ++s.histogram[bin];
      s.inside += v >= inside.low && v <= inside.high ? 1 : 0;
    }
    of_piece[w] = s;
  });
  Summary<kBounds> all;
  for (const auto& s : of_piece) {
    all.low = std::min(all.low, s.low), all.high = std::max(all.high, s.high), all.sum += s.sum;
    all.inside += s.inside;
    for (std::size_t b = 0; b <= kBounds; ++b) all.histogram[b] += s.histogram[b];
  }
  return all;
}
/// Collective. Of all ranks' numbers.
template <std::size_t kBounds>
Summary<kBounds> summary(const Comm& comm, Pieces values, const std::array<double, kBounds>& bounds, Interval inside) {
  Summary<kBounds> s = summary(values, bounds, inside);
  s.low = comm.min(s.low), s.high = comm.max(s.high), s.sum = comm.sum(s.sum), s.inside = comm.sum(s.inside);
  comm.reduce(std::span<std::int64_t>(s.histogram), Op::kSum);
  return s;
}
std::int64_t count(const Comm& comm, Pieces values) {
  std::int64_t n = 0;
  for (const auto& piece : values) n += std::ssize(piece);
  return comm.sum(n);
}
/// % of n in the bins [first, last).
template <std::size_t kBins>
double share(const std::array<std::int64_t, kBins>& histogram, std::int64_t n, std::size_t first, std::size_t last) {
  std::int64_t in = 0;
  for (std::size_t b = first; b < last; ++b) in += histogram[b];
  return 100 * static_cast<double>(in) / static_cast<double>(n);
}

LengthStatistics length_statistics(const Comm& comm, Pieces lengths) {
  LengthStatistics s;
  const std::int64_t n = count(comm, lengths);
  if (n == 0) return s;
  const auto all = summary(comm, lengths, length_bounds(), {std::numbers::sqrt2 / 2, std::numbers::sqrt2});
  s.min = all.low, s.mean = all.sum / static_cast<double>(n), s.max = all.high;
  s.histogram = all.histogram;
  s.below_half = share(s.histogram, n, 0, 3);
  s.unit_share = 100 * static_cast<double>(all.inside) / static_cast<double>(n);
  s.above_two = share(s.histogram, n, 11, 14);
  const std::array<std::int64_t, 2> ks{percentile_index(1, n), percentile_index(99, n)};
  const std::vector<double> p = order_statistics(comm, lengths, ks);
  s.p1 = p[0], s.p99 = p[1];
  return s;
}

QualityStatistics quality_statistics(const Comm& comm, Pieces q) {
  static constexpr std::array<double, 9> kTenths{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  QualityStatistics s;
  const std::int64_t n = count(comm, q);
  if (n == 0) return s;
  const auto all = summary(comm, q, kTenths, {0, 1});
  s.min = all.low, s.mean = all.sum / static_cast<double>(n);
  s.histogram = all.histogram;
  s.below_01 = share(s.histogram, n, 0, 1), s.below_02 = share(s.histogram, n, 0, 2);
  s.above_05 = share(s.histogram, n, 5, 10), s.above_08 = share(s.histogram, n, 8, 10);
  const std::array<std::int64_t, 2> ks{percentile_index(0.1, n), percentile_index(1, n)};
  const std::vector<double> p = order_statistics(comm, q, ks);
  s.p01 = p[0], s.p1 = p[1];
  return s;
}

}  // namespace

const std::array<double, 13>& length_bounds() noexcept {
  static const std::array<double, 13> bounds{0.25,
                                             std::exp2(-1.5),
                                             0.5,
                                             std::exp2(-0.75),
                                             std::exp2(-0.5),
                                             std::exp2(-0.25),
                                             1,
                                             std::exp2(0.25),
                                             std::exp2(0.5),
                                             std::exp2(0.75),
                                             2,
                                             std::exp2(1.5),
                                             4};
  return bounds;
}

MeshStatistics statistics(const Comm& comm, const DistMesh& dist, Measure measure, int threads) {
  const bool with_metric = measure == Measure::kInMetric;
  MeshStatistics s;
  s.with_metric = with_metric;
  IdVector<VertId, VertMetric> metric;
  if (with_metric) metric = metrics(dist, threads);
  const IdVector<VertId, VertMetric>* m = with_metric ? &metric : nullptr;

  std::vector<double> q(with_metric ? dist.mesh.tet_slots() : 0);
  const TetSums t = tet_pass(dist.mesh, m, q, threads);
  s.tets = comm.sum(static_cast<std::int64_t>(dist.mesh.tet_slots()));
  s.vertices = dist.global_verts;
  s.nonpositive_tets = comm.sum(t.nonpositive);
  s.volume = comm.sum(t.volume);
  s.min_volume = comm.min(t.min_volume);
  s.complexity = comm.sum(t.complexity);
  const double max_cos = comm.max(t.max_cos), min_cos = comm.min(t.min_cos);
  s.dihedral.min = 180 / std::numbers::pi * std::acos(max_cos);
  s.dihedral.max = 180 / std::numbers::pi * std::acos(min_cos);
  s.dihedral.histogram_10deg = t.angles;
  comm.reduce(std::span<std::int64_t>(s.dihedral.histogram_10deg), Op::kSum);
  std::vector<std::span<const double>> pieces;
  for (int w = 0; with_metric && w < threads; ++w) {
    const std::size_t first = share_begin(q.size(), w, threads);
    pieces.emplace_back(q.data() + first, share_begin(q.size(), w + 1, threads) - first);
  }
  if (with_metric) s.quality = quality_statistics(comm, pieces);
  q = {};

  const Edges e = edges_of(comm, dist, m, threads);
  s.edges = comm.sum(e.count);
  pieces.assign(e.lengths.begin(), e.lengths.end());
  if (with_metric) s.length = length_statistics(comm, pieces);
  return s;
}

}  // namespace skein
