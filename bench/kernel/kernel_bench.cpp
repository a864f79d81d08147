// Times of the kernel's primitives and operators: kernel_bench [--benchmark_filter=...]. One JSON line each, or what
// --benchmark_format asks for. Cycles are of the processor's nominal frequency.
//
// Operators run over a whole mesh of some 50,000 tetrahedra whose metric asks for them. Counters: `tried` and `done`
// operations per sweep; `ns_per_done` is the time of the whole sweep, refusals included, over what was done, and
// `ns_per_try` the same over all attempts.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>
#include <vector>

#include "kernel/operators/collapse.hpp"
#include "kernel/operators/insert.hpp"
#include "kernel/operators/smooth.hpp"
#include "kernel/operators/swap.hpp"
#include "kernel/recipe.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/check.hpp"
#include "mesh/predicates.hpp"
#include "tests/kernel/metrics.hpp"
#include "tests/support/tet_meshes.hpp"

namespace skein::bench {
namespace {

constexpr int kCells = 20;  ///< per axis; six tetrahedra in each

/// A cube of kCells^3 cells, perturbed, in a metric with these sizes in cells.
Part make_part(double hx, double hy, double hz) {
  Part p;
  p.mesh = test::make_mesh({.n = kCells, .perturb = 0.25});
  compact(p.mesh);
  test::SmoothMetric m;
  m.size = {hx / kCells, hy / kCells, hz / kCells};
  m.turn = {0.7, 0.5, 0};
  test::set_metric(p.mesh, m);
  prepare(p);
  return p;
}

/// Corners and metrics of tetrahedra, one behind the other as a sweep reads them.
struct Loose {
  std::vector<std::array<Vec3, 4>> x;
  std::vector<std::array<VertMetric, 4>> m;
  Loose() {
    const Part p = make_part(1, 1, 0.3);
    for (std::size_t t = 0; t < 1024; ++t) {
      const auto& v = p.mesh.tet2vert[to_id<TetId>(t * 37)];
      x.push_back({p.x(v[0]), p.x(v[1]), p.x(v[2]), p.x(v[3])});
      m.push_back({p.mesh.metric[v[0]], p.mesh.metric[v[1]], p.mesh.metric[v[2]], p.mesh.metric[v[3]]});
    }
  }
};
const Loose& loose() {
  static const Loose l;
  return l;
}

template <class Use>
void each(benchmark::State& state, Use&& use) {
  const Loose& l = loose();
  for (auto _ : state) {
    for (std::size_t i = 0; i < l.x.size(); ++i) benchmark::DoNotOptimize(use(l.x[i], l.m[i]));
  }
  state.counters["ns_per_op"] =
      benchmark::Counter(1e-9 * static_cast<double>(state.iterations() * static_cast<std::int64_t>(l.x.size())),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void quality_cubed_op(benchmark::State& state) {
  each(state,
       [](const auto& x, const auto& m) { return quality_cubed(x[0], x[1], x[2], x[3], m[0], m[1], m[2], m[3]); });
}
void orient3d_op(benchmark::State& state) {
  each(state, [](const auto& x, const auto&) { return orient3d_sign(x[0], x[1], x[2], x[3]); });
}
void orient3d_exact_op(benchmark::State& state) {
  each(state, [](const auto& x, const auto&) { return orient3d_exact(x[0], x[1], x[2], x[3]); });
}
void edge_length_op(benchmark::State& state) {
  each(state, [](const auto& x, const auto& m) { return edge_length(m[0].m, m[1].m, x[1] - x[0]); });
}
void tensor_exp_op(benchmark::State& state) {
  each(state, [](const auto&, const auto& m) { return exp(1e-4 * m[0].m); });
}

/// Calls try_one(part, operators, t) for every tetrahedron of a fresh copy per iteration.
struct Operators {
  Cavity cavity;
  Inserter insert;
  Collapser collapse;
  Swapper swap;
  Smoother smooth;
  explicit Operators(Part& p) : cavity(p), insert(p, cavity), collapse(p, cavity), swap(p, cavity), smooth(p) {}
};
struct Tally {
  std::int64_t tried = 0, done = 0;
  void add(bool did) {
    ++tried;
    done += did;
  }
};

template <class Try>
void sweep(benchmark::State& state, const Part& start, Try&& try_one) {
  double seconds = 0;
  Tally all;
  for (auto _ : state) {
    Part part = start;
    Operators op(part);
    const std::size_t n = part.mesh.tet_slots();
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < n; ++i) {
      const auto t = to_id<TetId>(i);
      if (part.mesh.is_live(t)) try_one(part, op, t, all);
    }
    const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    state.SetIterationTime(s);
    seconds += s;
  }
  const auto runs = static_cast<double>(state.iterations());
  state.counters["tried"] = static_cast<double>(all.tried) / runs;
  state.counters["done"] = static_cast<double>(all.done) / runs;
  state.counters["ns_per_try"] = 1e9 * seconds / static_cast<double>(std::max<std::int64_t>(all.tried, 1));
  state.counters["ns_per_done"] = 1e9 * seconds / static_cast<double>(std::max<std::int64_t>(all.done, 1));
}

/// The edge of t that is extreme in length: its place in kEdgeVerts.
std::size_t extreme_edge(const Part& p, TetId t, double sign, double& length) {
  const auto& v = p.mesh.tet2vert[t];
  std::size_t best = 0;
  length = -1e300;
  for (std::size_t e = 0; e < 6; ++e) {
    const double l = sign * p.length(v[kEdgeVerts[e][0]], v[kEdgeVerts[e][1]]);
    if (l > length) {
      length = l;
      best = e;
    }
  }
  length *= sign;
  return best;
}

void insert_op(benchmark::State& state) {
  sweep(state, make_part(0.5, 0.5, 0.5), [](Part& p, Operators& op, TetId t, Tally& tally) {
    double l;
    const auto& e = kEdgeVerts[extreme_edge(p, t, 1, l)];
    const auto v = p.mesh.tet2vert[t];
    if (l <= p.options.method.lengths.split_above) return;
    tally.add(op.insert.on_edge(t, v[e[0]], v[e[1]], 0.5) == InsertResult::kDone);
  });
}
void collapse_op(benchmark::State& state) {
  sweep(state, make_part(3, 3, 3), [](Part& p, Operators& op, TetId t, Tally& tally) {
    double l;
    const auto& e = kEdgeVerts[extreme_edge(p, t, -1, l)];
    const auto v = p.mesh.tet2vert[t];
    if (l >= p.options.method.lengths.collapse_below) return;
    tally.add(op.collapse.collapse(v[e[0]], v[e[1]], t, p.options.method.lengths.split_above, KeepFloor{0.027, 0.5}));
  });
}
void swap_edge_op(benchmark::State& state) {
  sweep(state, make_part(1, 1, 0.4), [](Part& p, Operators& op, TetId t, Tally& tally) {
    const auto v = p.mesh.tet2vert[t];
    for (const auto& e : kEdgeVerts) {
      const bool did = op.swap.edge(t, v[e[0]], v[e[1]], RaiseWorst{1.05});
      tally.add(did);
      if (did) return;
    }
  });
}
void swap_face_op(benchmark::State& state) {
  sweep(state, make_part(1, 1, 0.4), [](Part&, Operators& op, TetId t, Tally& tally) {
    for (std::size_t f = 0; f < 4; ++f) {
      const bool did = op.swap.face(make_face(t, f), RaiseWorst{1.05});
      tally.add(did);
      if (did) return;
    }
  });
}
void smooth_op(benchmark::State& state) {
  sweep(state, make_part(1, 1, 1), [](Part& p, Operators& op, TetId t, Tally& tally) {
    for (const VertId v : p.mesh.tet2vert[t]) {
      if (p.mesh.vert2tet[v] == t) tally.add(op.smooth.move(v, SmoothBall{}));  // each vertex once
    }
  });
}

/// The whole recipe: tetrahedra per second of the result.
void adapt_part_op(benchmark::State& state) {
  const double h = 0.01 * static_cast<double>(state.range(0));
  const Part start = make_part(h, h, h);
  std::size_t tets = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Part part = start;
    state.ResumeTiming();
    adapt_part(part);
    tets += count_tets(part.mesh);
  }
  state.counters["tets_per_second"] = benchmark::Counter(static_cast<double>(tets), benchmark::Counter::kIsRate);
}

BENCHMARK(quality_cubed_op);
BENCHMARK(orient3d_op);
BENCHMARK(orient3d_exact_op);
BENCHMARK(edge_length_op);
BENCHMARK(tensor_exp_op);
BENCHMARK(insert_op)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(collapse_op)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(swap_edge_op)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(swap_face_op)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(smooth_op)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(adapt_part_op)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);  // size in % of a cell

/// A line per benchmark: its counters, with cycles beside nanoseconds.
class JsonLines final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& /*context*/) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    const double cycles_per_ns = 1e-9 * benchmark::CPUInfo::Get().cycles_per_second;
    for (const Run& run : runs) {
      nlohmann::ordered_json line{{"benchmark", run.benchmark_name()}};
      if (run.error_occurred) line["error"] = run.error_message;
      for (const auto& [name, counter] : run.counters) {
        line[name] = counter.value;
        constexpr std::string_view kTime = "ns_per_";
        if (name.starts_with(kTime)) line["cycles_per_" + name.substr(kTime.size())] = counter.value * cycles_per_ns;
      }
      std::cout << line.dump() << std::endl;
    }
  }
};

}  // namespace
}  // namespace skein::bench

int main(int argc, char** argv) {
  const bool formatted = std::any_of(argv, argv + argc, [](std::string_view word) {
    return word.starts_with("--benchmark_format") || word.starts_with("--benchmark_list_tests");
  });
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  skein::bench::JsonLines lines;
  if (formatted) {
    benchmark::RunSpecifiedBenchmarks();
  } else {
    benchmark::RunSpecifiedBenchmarks(&lines);
  }
  benchmark::Shutdown();
}
