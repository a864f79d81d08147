// The library on arrays: both conventions, carried fields, errors, progress, communicators.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>

#include "tests/api/arrays.hpp"

namespace skein::test {
namespace {

/// Sizes for about 5,000 tetrahedra.
std::vector<double> sizes(std::size_t n) { return std::vector<double>(n, 0.12); }

/// What `work` throws: its code and text, the same on all ranks of comm (otherwise the text says so).
struct Thrown {
  ErrorCode code = ErrorCode::kOk;
  std::string text;
};
Thrown thrown_by(MPI_Comm comm, const std::function<void()>& work) {
  Thrown t;
  try {
    work();
  } catch (const Error& e) {
    t = {e.code(), e.what()};
  }
  std::array<char, 512> mine{}, first{};
  t.text.copy(mine.data(), mine.size() - 1);
  first = mine;
  MPI_Bcast(first.data(), first.size(), MPI_CHAR, 0, comm);
  int same = first == mine ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_INT, MPI_MIN, comm);
  if (same == 0) t.text = "ranks have different errors: " + t.text;
  return t;
}

Adapted<SlicedMesh> adapt_cube(MPI_Comm comm, const Options& options = {}, double size = 0.12) {
  SlicedMesh mesh = sliced(comm, cube(4));
  std::vector<double> h(mesh.coords.size(), size);
  return adapt(comm, std::move(mesh), Target::size(std::move(h)), {}, options);
}

TEST(Adapt, SlicesWithALinearField) {
  SlicedMesh mesh = sliced(MPI_COMM_WORLD, cube(4, Regions::kTwo));
  Fields fields = linear_fields(mesh.coords);
  Target target = Target::size(sizes(mesh.coords.size()));
  Options options;
  options.return_metric = true;
  const auto out = adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target), std::move(fields), options);
  EXPECT_LT(worst_error(MPI_COMM_WORLD, out.mesh.coords, out.fields), 1e-13);
  EXPECT_EQ(out.metric.size(), 6 * out.mesh.coords.size());
  const Report& r = out.report;
  EXPECT_EQ(r.vertices_in, 125);
  EXPECT_EQ(r.tets_in, 384);
  EXPECT_GT(r.tets, 3000);
  EXPECT_GT(r.unit_edges, 85);
  EXPECT_GT(r.quality_min, 0.15);
  EXPECT_GT(r.quality_mean, 0.75);
  EXPECT_GT(r.seconds, 0);
  EXPECT_EQ(r.phases.front().name, "read");
  EXPECT_EQ(r.notes.size(), 1U) << "faces between the two regions have no triangle";
  std::int64_t tets = std::ssize(out.mesh.tets);
  MPI_Allreduce(MPI_IN_PLACE, &tets, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(tets, r.tets);
}

TEST(Adapt, PartsGiveWhatSlicesGive) {
  const WholeMesh whole = cube(4, Regions::kTwoTagged);
  SlicedMesh slices = sliced(MPI_COMM_WORLD, whole);
  Target target = Target::size(sizes(slices.coords.size()));
  const auto a = adapt(MPI_COMM_WORLD, std::move(slices), std::move(target));
  PartitionedMesh mesh = parts(MPI_COMM_WORLD, whole, 1000);
  target = Target::size(sizes(mesh.coords.size()));
  Fields fields = linear_fields(mesh.coords);
  const auto b = adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target), std::move(fields));
  EXPECT_EQ(a.report.tets, b.report.tets);
  EXPECT_EQ(a.report.vertices, b.report.vertices);
  EXPECT_LT(worst_error(MPI_COMM_WORLD, b.mesh.coords, b.fields), 1e-13);
  EXPECT_EQ(a.mesh.triangles.size(), b.mesh.triangles.size());
  EXPECT_EQ(a.mesh.edges.size(), b.mesh.edges.size());
  std::int64_t top = 0;
  for (const std::int64_t g : b.mesh.local2global) top = std::max(top, g);
  MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPI_INT64_T, MPI_MAX, MPI_COMM_WORLD);
  EXPECT_EQ(top + 1, b.report.vertices) << "numbers without gaps";
}

/// The corners of some entities, each sorted, of all ranks, sorted.
template <std::size_t N>
std::vector<std::array<Point, N>> places(const std::vector<std::array<Point, N>>& mine) {
  const int n = static_cast<int>(3 * N * mine.size()), ranks = ranks_in(MPI_COMM_WORLD);
  std::vector<int> counts(static_cast<std::size_t>(ranks)), first(counts.size(), 0);
  MPI_Allgather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  for (std::size_t r = 1; r < first.size(); ++r) first[r] = first[r - 1] + counts[r - 1];
  std::vector<std::array<Point, N>> all(static_cast<std::size_t>(first.back() + counts.back()) / (3 * N));
  MPI_Allgatherv(mine.data(), n, MPI_DOUBLE, all.data(), counts.data(), first.data(), MPI_DOUBLE, MPI_COMM_WORLD);
  for (auto& corners : all) std::sort(corners.begin(), corners.end());
  std::sort(all.begin(), all.end());
  return all;
}

/// Of those of a partitioned mesh with these local numbers.
template <std::size_t N>
std::vector<std::array<Point, N>> places(const PartitionedMesh& m,
                                         const std::vector<std::array<std::int32_t, N>>& entities,
                                         const std::vector<std::int32_t>& numbers) {
  std::vector<std::array<Point, N>> mine;
  for (const std::int32_t i : numbers) {
    auto& corners = mine.emplace_back();
    for (std::size_t k = 0; k < N; ++k) corners[k] = m.coords[entities[i][k]];
  }
  return places(mine);
}

TEST(Adapt, RequiredEntitiesStayBitByBit) {
  PartitionedMesh mesh = parts(MPI_COMM_WORLD, cube(5));
  const auto tets = static_cast<std::int32_t>(mesh.tets.size());
  mesh.required_tets = {0, tets / 3, tets - 1};
  for (std::int32_t t = 2; t < static_cast<std::int32_t>(mesh.triangles.size()); t += 7)
    mesh.required_triangles.push_back(t);
  const auto tets_before = places(mesh, mesh.tets, mesh.required_tets);
  auto triangles_before = places(mesh, mesh.triangles, mesh.required_triangles);
  triangles_before.erase(std::unique(triangles_before.begin(), triangles_before.end()), triangles_before.end());
  Target target = Target::size(std::vector<double>(mesh.coords.size(), 0.09));
  const auto out = adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target));
  EXPECT_EQ(places(out.mesh, out.mesh.tets, out.mesh.required_tets), tets_before);
  EXPECT_EQ(places(out.mesh, out.mesh.triangles, out.mesh.required_triangles), triangles_before);
  EXPECT_GT(out.report.tets, 5000) << "the rest is adapted";
}

TEST(Adapt, RequiredTetrahedraOfSlices) {
  SlicedMesh mesh = sliced(MPI_COMM_WORLD, cube(4));
  if (rank_in(MPI_COMM_WORLD) == 0) mesh.required_tets = {17, 380};
  Target target = Target::size(std::vector<double>(mesh.coords.size(), 0.4));
  const auto out = adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target));
  std::int64_t kept = std::ssize(out.mesh.required_tets);
  MPI_Allreduce(MPI_IN_PLACE, &kept, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(kept, 2);
}

TEST(Adapt, AResultIsAnInput) {
  PartitionedMesh mesh = parts(MPI_COMM_WORLD, cube(3));
  for (int i = 0; i < 2; ++i) {
    Target target = Target::size(sizes(mesh.coords.size()));
    auto out = adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target));
    EXPECT_GT(out.report.quality_min, 0.15);
    EXPECT_TRUE(out.report.notes.empty());
    mesh = std::move(out.mesh);
  }
}

TEST(Adapt, ToAMetricAndToAField) {
  SlicedMesh mesh = sliced(MPI_COMM_WORLD, cube(4));
  Options options;
  options.complexity = 300;
  std::vector<double> metric, field;
  for (const Point& x : mesh.coords) {
    metric.insert(metric.end(), {4, 0, 4, 0, 0, 16});
    field.push_back(x[0] * x[0] + x[1] * x[2]);
  }
  SlicedMesh again = mesh;
  const auto a = adapt(MPI_COMM_WORLD, std::move(mesh), Target::metric(metric), {}, options);
  EXPECT_NEAR(a.report.complexity, 300, 30);
  const auto b = adapt(MPI_COMM_WORLD, std::move(again), Target::field(field), {}, options);
  EXPECT_NEAR(b.report.complexity, 300, 60);
}

// From 384 tetrahedra, with sizes that vary by a factor of fifty within them.
TEST(Adapt, WhatIsWantedIsMetOnTheResult) {
  const auto run = [](auto&& choose) {
    SlicedMesh mesh = sliced(MPI_COMM_WORLD, cube(4));
    std::vector<double> h;
    for (const Point& x : mesh.coords) h.push_back(x[0] < 0.1 ? 0.01 : 0.5);
    Options options;
    options.gradation = 0;
    choose(options);
    return adapt(MPI_COMM_WORLD, std::move(mesh), Target::size(std::move(h)), {}, options).report;
  };
  EXPECT_NEAR(double(run([](Options& o) { o.elements = 12000; }).tets) / 12000, 1, 0.05);
  EXPECT_NEAR(double(run([](Options& o) { o.vertices = 3000; }).vertices) / 3000, 1, 0.05);
  EXPECT_NEAR(run([](Options& o) { o.complexity = 1500; }).complexity / 1500, 1, 0.05);
}

TEST(Adapt, OwnSizesAndFrozenReferences) {
  Options options;
  options.freeze_patches = {1};
  SlicedMesh mesh = sliced(MPI_COMM_WORLD, cube(4));
  const auto ones = [](const SlicedMesh& m) {
    std::int64_t n = std::count(m.triangle_refs.begin(), m.triangle_refs.end(), 1);
    MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    return n;
  };
  const std::int64_t before = ones(mesh);
  ASSERT_GT(before, 0);
  const auto out = adapt(MPI_COMM_WORLD, mesh, Target::own_sizes(), {}, options);
  EXPECT_NEAR(double(out.report.tets) / 384, 1, 0.3);
  EXPECT_EQ(ones(out.mesh), before);
  options.elements = 5000;
  const auto fine = adapt(MPI_COMM_WORLD, std::move(mesh), Target::own_sizes(), {}, options);
  EXPECT_EQ(ones(fine.mesh), before);
  EXPECT_GT(fine.report.tets, 3000);
}

TEST(Adapt, AnErrorStaysInItsCommunicator) {
  const int rank = rank_in(MPI_COMM_WORLD), ranks = ranks_in(MPI_COMM_WORLD);
  const bool bad = rank < (ranks + 1) / 2;
  MPI_Comm half = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, bad ? 0 : 1, -rank, &half);
  {
    const LeakCounter counter(half);
    const Thrown t = thrown_by(half, [&] { (void)adapt_cube(half, {}, bad ? -1 : 0.2); });
    EXPECT_EQ(t.code, bad ? ErrorCode::kInput : ErrorCode::kOk) << t.text;
    EXPECT_EQ(t.text, bad ? "the sizes: the size at vertex 0 is -1; sizes must be greater than zero" : "");
    EXPECT_GE(counter.made(), 2);
    EXPECT_EQ(counter.left(), 0);
  }
  EXPECT_GT(adapt_cube(half).report.tets, 3000) << "the communicator still works";
  MPI_Comm_free(&half);
  int alive = 1;
  MPI_Allreduce(MPI_IN_PLACE, &alive, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(alive, ranks);
}

TEST(Adapt, ErrorsTellWhatIsWrong) {
  const auto expect = [](ErrorCode code, const std::string& part,
                         const std::function<void(SlicedMesh&, Target&, Fields&, Options&)>& spoil) {
    SlicedMesh mesh = sliced(MPI_COMM_WORLD, cube(3));
    Target target = Target::size(sizes(mesh.coords.size()));
    Fields fields;
    Options options;
    if (rank_in(MPI_COMM_WORLD) == ranks_in(MPI_COMM_WORLD) - 1) spoil(mesh, target, fields, options);
    const Thrown t = thrown_by(
        MPI_COMM_WORLD, [&] { (void)adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target), fields, options); });
    EXPECT_EQ(t.code, code) << t.text;
    EXPECT_NE(t.text.find(part), std::string::npos) << t.text;
  };
  const bool alone = ranks_in(MPI_COMM_WORLD) == 1;
  using M = SlicedMesh;
  using T = Target;
  using F = Fields;
  using O = Options;
  expect(ErrorCode::kInput, "the sizes: ", [](M&, T& t, F&, O&) { t.values.pop_back(); });
  expect(ErrorCode::kInput, "the fields: ", [alone](M&, T&, F& f, O&) {
    f.values.push_back(1);
    if (alone) f.width = 1;
  });
  expect(ErrorCode::kUsage, "rounds", [](M&, T&, F&, O& o) { o.rounds = 0; });
  expect(ErrorCode::kUsage, "norm", [](M&, T&, F&, O& o) { o.norm = std::nan(""); });
  expect(ErrorCode::kInvalidMesh, "counted from 0", [](M& m, T&, F&, O&) { m.corners = {64}; });
  expect(ErrorCode::kInvalidMesh, "references", [](M& m, T&, F&, O&) { m.tet_refs.pop_back(); });
  expect(ErrorCode::kInvalidMesh, "not in the mesh: 161", [](M& m, T&, F&, O&) { m.tets.back()[0] = 64; });
  expect(ErrorCode::kInvalidMesh, "repeated vertex", [](M& m, T&, F&, O&) { m.tets[0][0] = m.tets[0][1]; });
  if (!alone) expect(ErrorCode::kUsage, "the same on all ranks", [](M&, T&, F&, O& o) { o.rounds = 2; });
}

/// The methods of tests: as the program reads them.
constexpr const char* kChapter = "preset = \"chapter\"\n";
constexpr const char* kChapterOtherwise = "preset = \"chapter\"\n[swap]\ngain = 1.3\n";

/// A file of this text, written by rank 0, as long as it lives.
class TextFile {
 public:
  explicit TextFile(const std::string& text)
      : path_("api_adapt_test.np" + std::to_string(ranks_in(MPI_COMM_WORLD)) + ".toml") {
    if (rank_in(MPI_COMM_WORLD) == 0) std::ofstream(path_) << text;
  }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  ~TextFile() {
    if (rank_in(MPI_COMM_WORLD) == 0) std::remove(path_.c_str());
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(Method, ByItsNameByTextAndByFileIsTheSame) {
  const auto coords_with = [](const std::function<void(Options&)>& choose) {
    Options options;
    choose(options);
    return adapt_cube(MPI_COMM_WORLD, options).mesh.coords;
  };
  const auto differ = [](const std::vector<Point>& a, const std::vector<Point>& b) {
    int differ = a != b ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &differ, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    return differ != 0;
  };
  const auto usual = coords_with([](Options&) {});
  const auto chapter = coords_with([](Options& o) { o.preset = "chapter"; });
  EXPECT_TRUE(differ(usual, chapter));
  EXPECT_EQ(chapter, coords_with([](Options& o) { o.config = kChapter; }));
  EXPECT_EQ(chapter, coords_with([](Options& o) {
              o.points = Options::Points::kCentroids;
              o.smoothing = Options::Smoothing::kSprings;
            }));
  EXPECT_EQ(usual, coords_with([](Options& o) {
              o.preset = "chapter";
              o.points = Options::Points::kEdges;
              o.smoothing = Options::Smoothing::kQuality;
            }));
  const TextFile file(kChapterOtherwise);
  const auto otherwise = coords_with([&](Options& o) { o.config_file = file.path(); });
  EXPECT_TRUE(differ(otherwise, chapter));
  EXPECT_EQ(otherwise, coords_with([](Options& o) { o.config = kChapterOtherwise; }));
}

TEST(Method, ErrorsTellWhatIsWrong) {
  const auto expect = [](ErrorCode code, const std::string& part, const std::function<void(Options&)>& spoil) {
    Options options;
    spoil(options);
    const Thrown t = thrown_by(MPI_COMM_WORLD, [&] { (void)adapt_cube(MPI_COMM_WORLD, options); });
    EXPECT_EQ(t.code, code) << t.text;
    EXPECT_NE(t.text.find(part), std::string::npos) << t.text;
  };
  expect(ErrorCode::kUsage, "there is no method 'best'", [](Options& o) { o.preset = "best"; });
  expect(ErrorCode::kUsage, "only one of", [](Options& o) { o.preset = "quick", o.config = kChapter; });
  expect(ErrorCode::kInput, "Options::config:2: there is no 'swap.gian'",
         [](Options& o) { o.config = "[swap]\ngian = 1.3\n"; });
  expect(ErrorCode::kInput, "no_such_file.toml: cannot be read",
         [](Options& o) { o.config_file = "no_such_file.toml"; });
  if (ranks_in(MPI_COMM_WORLD) == 1) return;
  expect(ErrorCode::kUsage, "the same on all ranks",
         [](Options& o) { o.preset = rank_in(MPI_COMM_WORLD) == 1 ? "quick" : "chapter"; });
}

TEST(Adapt, PartsThatDoNotFitAreRefused) {
  const auto expect = [](const std::string& part, const std::function<void(PartitionedMesh&)>& spoil) {
    PartitionedMesh mesh = parts(MPI_COMM_WORLD, cube(3));
    spoil(mesh);
    Target target = Target::size(sizes(mesh.coords.size()));
    const Thrown t =
        thrown_by(MPI_COMM_WORLD, [&] { (void)adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target)); });
    EXPECT_EQ(t.code, ErrorCode::kInvalidMesh) << t.text;
    EXPECT_NE(t.text.find(part), std::string::npos) << t.text;
  };
  expect("twice on one rank", [](PartitionedMesh& m) { m.local2global[1] = m.local2global[0]; });
  expect("negative", [](PartitionedMesh& m) { m.local2global[1] = -2; });
  expect("local number 1000", [](PartitionedMesh& m) { m.tets[0][0] = 1000; });
  if (ranks_in(MPI_COMM_WORLD) == 1) return;
  expect("same bits", [](PartitionedMesh& m) {
    for (auto& x : m.coords) x[0] += 1e-9 * rank_in(MPI_COMM_WORLD);
  });
}

TEST(Adapt, NoCommunicatorNoTetrahedra) {
  EXPECT_THROW((void)adapt(MPI_COMM_NULL, SlicedMesh(), Target()), Error);
  const Thrown t = thrown_by(MPI_COMM_WORLD, [] { (void)adapt(MPI_COMM_WORLD, SlicedMesh(), Target()); });
  EXPECT_EQ(t.text, "the mesh has no tetrahedra");
}

TEST(Progress, TellsPhasesAndCancels) {
  Options options;
  std::vector<std::string> begun, ended;
  options.progress = [&](const Progress& p) {
    (p.finished ? ended : begun).push_back(p.phase);
    return true;
  };
  const auto out = adapt_cube(MPI_COMM_WORLD, options);
  EXPECT_EQ(begun, ended);
  ASSERT_EQ(ended.size(), out.report.phases.size());
  for (std::size_t i = 0; i < ended.size(); ++i) EXPECT_EQ(ended[i], out.report.phases[i].name);

  const LeakCounter counter(MPI_COMM_WORLD);
  for (const bool at_end : {false, true}) {
    std::string last;
    options.progress = [&](const Progress& p) {
      last = p.phase;
      const bool stops = rank_in(MPI_COMM_WORLD) == ranks_in(MPI_COMM_WORLD) - 1;
      return !(stops && p.finished == at_end && p.phase == "round 1: adapt");
    };
    const Thrown t = thrown_by(MPI_COMM_WORLD, [&] { (void)adapt_cube(MPI_COMM_WORLD, options); });
    EXPECT_EQ(t.code, ErrorCode::kCancelled);
    EXPECT_EQ(t.text, "cancelled by the caller in phase 'round 1: adapt'");
    EXPECT_EQ(last, "round 1: adapt");
  }
  options.progress = [&](const Progress&) -> bool { throw std::runtime_error("no more patience"); };
  const Thrown t = thrown_by(MPI_COMM_WORLD, [&] { (void)adapt_cube(MPI_COMM_WORLD, options); });
  EXPECT_EQ(t.code, ErrorCode::kCancelled);
  EXPECT_NE(t.text.find("no more patience"), std::string::npos);
  EXPECT_EQ(counter.left(), 0);
}

TEST(Version, IsThatOfTheHeaders) { EXPECT_STREQ(version(), SKEIN_VERSION); }

}  // namespace
}  // namespace skein::test
