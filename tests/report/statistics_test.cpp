// Statistics: known values of a unit tetrahedron, all of them against brute force, and no trace of ranks and threads.
#include "report/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "metric/mesh_metric.hpp"
#include "report/order_statistics.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

constexpr double kEdge = 0.4;
constexpr double kDihedral = 70.528779365509308;  ///< degrees: acos(1/3)

/// One regular tetrahedron with edges of length kEdge.
WholeMesh regular_tet() {
  const double s = kEdge / std::sqrt(8.0);
  WholeMesh w;
  w.coords = {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}};
  w.tets = {{0, 1, 2, 3}};
  const auto x = [&](std::size_t k) { return w.coords[w.tets[0][k]]; };
  if (volume6(x(0), x(1), x(2), x(3)) < 0) std::swap(w.tets[0][2], w.tets[0][3]);
  w.tet_ref = {1};
  return w;
}

/// Some shape without two equal lengths or angles.
WholeMesh bent_cube(int n) {
  WholeMesh w = cube(n);
  for (Vec3& x : w.coords) {
    x = {x.x + 0.11 * std::sin(2.3 * x.y + x.z), 1.3 * x.y + 0.07 * std::cos(3 * x.x), x.z + 0.13 * x.x * x.y};
  }
  return w;
}
/// Anisotropic, and different at every vertex.
SymTensor varying(Vec3 x) {
  return {3 + 3 * x.x, 0.7 * x.y, 4 - x.z, 0.3 * std::sin(5 * x.x), -0.5 * x.z, 2 + std::cos(3 * x.y)};
}

TEST(Statistics, OfARegularTetrahedronInItsMetric) {
  const Comm& comm = world();
  const DistMesh dist = with_metric(comm, regular_tet(), [](Vec3) { return isotropic(-2 * std::log(kEdge)); });
  const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric);
  EXPECT_EQ(s.tets, 1);
  EXPECT_EQ(s.vertices, 4);
  EXPECT_EQ(s.edges, 6);
  EXPECT_EQ(s.nonpositive_tets, 0);
  const double volume = std::pow(kEdge, 3) / (6 * std::numbers::sqrt2);
  EXPECT_NEAR(s.volume, volume, 1e-15);
  EXPECT_NEAR(s.min_volume, volume, 1e-15);
  EXPECT_NEAR(s.complexity, volume / std::pow(kEdge, 3), 1e-13);
  for (const double angle : {s.dihedral.min, s.dihedral.max}) EXPECT_NEAR(angle, kDihedral, 1e-10);
  EXPECT_EQ(s.dihedral.histogram_10deg[7], 6);
  for (const double l : {s.length.min, s.length.p1, s.length.mean, s.length.p99, s.length.max})
    EXPECT_NEAR(l, 1, 1e-12);
  EXPECT_EQ(s.length.unit_share, 100);
  for (const double q : {s.quality.min, s.quality.p1, s.quality.mean}) EXPECT_NEAR(q, 1, 1e-12);
  EXPECT_EQ(s.quality.above_08, 100);
}

TEST(Statistics, AUnitTetrahedronOfAnyMetricHasLengthsAndQualityOne) {
  const Comm& comm = world();
  // x -> A x turns M into A^-T M A^-1; its inverse is A M^-1 A'.
  const auto map = [](Vec3 x) { return Vec3{2 * x.x, 0.5 * x.y + 0.3 * x.x, 0.01 * x.z - 0.02 * x.y}; };
  const Vec3 a = map({1, 0, 0}), b = map({0, 1, 0}), c = map({0, 0, 1});
  const double d = dot(cross(a, b), c);
  const Vec3 ra = (1 / d) * cross(b, c), rb = (1 / d) * cross(c, a), rc = (1 / d) * cross(a, b);  // rows of A^-1
  const auto entry = [&](double Vec3::*i, double Vec3::*j) {
    return (ra.*i * ra.*j + rb.*i * rb.*j + rc.*i * rc.*j) / (kEdge * kEdge);
  };
  const SymTensor m{entry(&Vec3::x, &Vec3::x), entry(&Vec3::x, &Vec3::y), entry(&Vec3::y, &Vec3::y),
                    entry(&Vec3::x, &Vec3::z), entry(&Vec3::y, &Vec3::z), entry(&Vec3::z, &Vec3::z)};
  WholeMesh w = regular_tet();
  for (Vec3& x : w.coords) x = map(x);
  const MeshStatistics s =
      statistics(comm, with_metric(comm, w, [&](Vec3) { return log(m); }), skein::Measure::kInMetric);
  EXPECT_NEAR(s.length.min, 1, 1e-6);
  EXPECT_NEAR(s.length.max, 1, 1e-6);
  EXPECT_NEAR(s.quality.min, 1, 1e-6);
  EXPECT_NEAR(s.complexity, 1 / (6 * std::numbers::sqrt2), 1e-6);
  EXPECT_LT(s.dihedral.min, 10);
}

TEST(Statistics, OfACube) {
  const Comm& comm = world();
  const int n = 3;
  const MeshStatistics s = statistics(comm, distribute(comm, slices(comm, cube(n))), skein::Measure::kInSpace);
  EXPECT_EQ(s.tets, 6 * n * n * n);
  EXPECT_EQ(s.vertices, 64);
  // Vertices - edges + faces - tetrahedra = 1; four faces per tetrahedron, those of the hull once.
  EXPECT_EQ(s.edges, s.vertices + (4 * s.tets + 12 * n * n) / 2 - s.tets - 1);
  EXPECT_NEAR(s.volume, 1, 1e-13);
  EXPECT_NEAR(s.min_volume, 1.0 / 6 / n / n / n, 1e-15);
  EXPECT_NEAR(s.dihedral.min, 45, 1e-10);
  EXPECT_NEAR(s.dihedral.max, 90, 1e-10);
  EXPECT_FALSE(s.with_metric);
  EXPECT_EQ(s.complexity, 0);
}

/// What is judged one by one, sorted.
struct Judged {
  std::vector<double> length, quality, angle, volume;
  double complexity = 0;
};
/// The mean of sqrt(det M) with its logarithm linear, by the midpoint rule in many small cells of the unit cube, which
/// is mapped onto the tetrahedron.
double mean_density(const std::array<VertMetric, 4>& m) {
  constexpr int kSteps = 16;
  double sum = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const auto at = [&](int k) { return (k % kSteps + 0.5) / kSteps; };
    const double a = at(i), b = at(i / kSteps) * (1 - a), c = at(i / kSteps / kSteps) * (1 - a - b);
    const double l = (1 - a - b - c) * std::log(m[0].sqrt_det) + a * std::log(m[1].sqrt_det) +
                     b * std::log(m[2].sqrt_det) + c * std::log(m[3].sqrt_det);
    sum += 6 * (1 - a) * (1 - a) * (1 - at(i / kSteps)) * std::exp(l);
  }
  return sum / (kSteps * kSteps * kSteps);
}

Judged judge(const WholeMesh& w) {
  Judged j;
  std::vector<VertMetric> m;
  for (const Vec3 x : w.coords) m.push_back(vert_metric_from_log(varying(x)));
  std::set<std::pair<std::int64_t, std::int64_t>> edges;
  for (const auto& t : w.tets) {
    const auto x = [&](std::size_t k) { return w.coords[t[k]]; };
    j.volume.push_back(volume6(x(0), x(1), x(2), x(3)) / 6);
    j.quality.push_back(quality(quality_cubed(x(0), x(1), x(2), x(3), m[t[0]], m[t[1]], m[t[2]], m[t[3]])));
    j.complexity += mean_density({m[t[0]], m[t[1]], m[t[2]], m[t[3]]}) * j.volume.back();
    for (const auto& e : kEdgeVerts) {
      edges.insert(std::minmax(t[e[0]], t[e[1]]));
      // The angle at the edge a b: between c and d, seen along it.
      const Vec3 a = x(e[0]), along = normalized(x(e[1]) - a);
      std::vector<Vec3> beside;
      for (std::size_t k = 0; k < 4; ++k) {
        if (k != e[0] && k != e[1]) beside.push_back(normalized(x(k) - a - dot(x(k) - a, along) * along));
      }
      j.angle.push_back(180 / std::numbers::pi * std::acos(std::clamp(dot(beside[0], beside[1]), -1.0, 1.0)));
    }
  }
  for (const auto& [a, b] : edges) j.length.push_back(edge_length(m[a].m, m[b].m, w.coords[b] - w.coords[a]));
  for (auto* v : {&j.length, &j.quality, &j.angle, &j.volume}) std::sort(v->begin(), v->end());
  return j;
}
double sum(const std::vector<double>& v) {
  double s = 0;
  for (const double x : v) s += x;
  return s;
}
/// % of the values in [low, high).
double percent(const std::vector<double>& v, double low, double high) {
  const auto n = std::count_if(v.begin(), v.end(), [&](double x) { return x >= low && x < high; });
  return 100.0 * static_cast<double>(n) / static_cast<double>(v.size());
}
double percentile(const std::vector<double>& v, double p) { return v[percentile_index(p, std::ssize(v))]; }

TEST(Statistics, AreWhatBruteForceFinds) {
  const Comm& comm = world();
  const WholeMesh w = bent_cube(4);
  const Judged j = judge(w);
  const MeshStatistics s = statistics(comm, with_metric(comm, w, varying), skein::Measure::kInMetric);
  EXPECT_EQ(s.tets, std::ssize(w.tets));
  EXPECT_EQ(s.vertices, std::ssize(w.coords));
  EXPECT_EQ(s.edges, std::ssize(j.length));
  EXPECT_EQ(s.nonpositive_tets, 0);
  EXPECT_NEAR(s.volume, sum(j.volume), 1e-12);
  EXPECT_NEAR(s.min_volume, j.volume.front(), 1e-15);
  EXPECT_NEAR(s.complexity, j.complexity, 2e-3 * j.complexity);  // both are quadratures

  EXPECT_NEAR(s.dihedral.min, j.angle.front(), 1e-7);
  EXPECT_NEAR(s.dihedral.max, j.angle.back(), 1e-7);
  for (std::size_t k = 0; k < 18; ++k) {
    const double share =
        100.0 * static_cast<double>(s.dihedral.histogram_10deg[k]) / static_cast<double>(j.angle.size());
    EXPECT_NEAR(share, percent(j.angle, 10.0 * static_cast<double>(k), 10.0 * static_cast<double>(k + 1)), 1e-9);
  }

  EXPECT_NEAR(s.length.min, j.length.front(), 1e-12);
  EXPECT_NEAR(s.length.p1, percentile(j.length, 1), 1e-12);
  EXPECT_NEAR(s.length.mean, sum(j.length) / static_cast<double>(j.length.size()), 1e-12);
  EXPECT_NEAR(s.length.p99, percentile(j.length, 99), 1e-12);
  EXPECT_NEAR(s.length.max, j.length.back(), 1e-12);
  EXPECT_NEAR(s.length.unit_share, percent(j.length, std::numbers::sqrt2 / 2, std::numbers::sqrt2), 1e-9);
  EXPECT_NEAR(s.length.below_half, percent(j.length, 0, 0.5), 1e-9);
  EXPECT_NEAR(s.length.above_two, percent(j.length, 2, 1e300), 1e-9);
  for (std::size_t k = 0; k + 1 < length_bounds().size(); ++k) {
    const double share = percent(j.length, length_bounds()[k], length_bounds()[k + 1]);
    EXPECT_NEAR(100.0 * static_cast<double>(s.length.histogram[k + 1]) / static_cast<double>(s.edges), share, 1e-9);
  }

  EXPECT_NEAR(s.quality.min, j.quality.front(), 1e-12);
  EXPECT_NEAR(s.quality.p01, percentile(j.quality, 0.1), 1e-12);
  EXPECT_NEAR(s.quality.p1, percentile(j.quality, 1), 1e-12);
  EXPECT_NEAR(s.quality.mean, sum(j.quality) / static_cast<double>(j.quality.size()), 1e-12);
  EXPECT_NEAR(s.quality.below_01, percent(j.quality, 0, 0.1), 1e-9);
  EXPECT_NEAR(s.quality.below_02, percent(j.quality, 0, 0.2), 1e-9);
  EXPECT_NEAR(s.quality.above_05, percent(j.quality, 0.5, 2), 1e-9);
  EXPECT_NEAR(s.quality.above_08, percent(j.quality, 0.8, 2), 1e-9);
}

/// What is added up, or found by sorting: equal on any number of ranks but for rounding.
std::vector<double> rounded_numbers(const MeshStatistics& s) {
  const auto& l = s.length;
  const auto& q = s.quality;
  return {s.volume, s.complexity, l.min, l.p1, l.mean, l.p99, l.max, q.min, q.p01, q.p1, q.mean};
}

TEST(Statistics, RanksAndThreadsDoNotMatter) {
  const Comm& comm = world();
  const WholeMesh w = bent_cube(5);
  const MeshStatistics alone =
      statistics(Comm::self(), with_metric(Comm::self(), w, varying), skein::Measure::kInMetric);
  const DistMesh dist = with_metric(comm, w, varying);
  for (const int threads : {1, 3}) {
    const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric, threads);
    EXPECT_EQ(s.tets, alone.tets);
    EXPECT_EQ(s.vertices, alone.vertices);
    EXPECT_EQ(s.edges, alone.edges);
    EXPECT_EQ(s.min_volume, alone.min_volume);
    EXPECT_EQ(s.dihedral.min, alone.dihedral.min);
    EXPECT_EQ(s.dihedral.max, alone.dihedral.max);
    EXPECT_EQ(s.dihedral.histogram_10deg, alone.dihedral.histogram_10deg);
    EXPECT_EQ(s.length.histogram, alone.length.histogram);
    EXPECT_EQ(s.length.unit_share, alone.length.unit_share);
    EXPECT_EQ(s.quality.histogram, alone.quality.histogram);
    const auto found = rounded_numbers(s), expected = rounded_numbers(alone);
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_NEAR(found[k], expected[k], 1e-12 * std::abs(expected[k])) << "number " << k;
    }
  }
}

TEST(Statistics, InvertedTetrahedraAreCountedAndHaveNoQuality) {
  const Comm& comm = world();
  DistMesh dist = with_metric(comm, bent_cube(4), varying);
  std::int64_t turned = 0;
  if (dist.mesh.tet_slots() > 3) {
    auto& v = dist.mesh.tet2vert[TetId{3}];
    std::swap(v[0], v[1]);
    turned = 1;
  }
  const MeshStatistics s = statistics(comm, dist, skein::Measure::kInMetric);
  EXPECT_EQ(s.nonpositive_tets, comm.sum(turned));
  EXPECT_GT(s.nonpositive_tets, 0);
  EXPECT_LT(s.min_volume, 0);
  EXPECT_EQ(s.quality.min, 0);
}

TEST(Statistics, TextHasTheCountsAndTheComplexity) {
  const Comm& comm = world();
  const std::string text = to_text(statistics(comm, with_metric(comm, cube(6), varying), skein::Measure::kInMetric));
  for (const char* part : {"1,296", "343", "complexity"}) EXPECT_NE(text.find(part), std::string::npos) << text;
}

}  // namespace
}  // namespace skein::test
