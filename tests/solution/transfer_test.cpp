// Transfer: linear fields are exact wherever the points are and on whichever rank; outside the nearest point counts.
#include "solution/transfer.hpp"

#include <gtest/gtest.h>

#include "adapt/adapt.hpp"
#include "comm/file.hpp"
#include "comm/phase_log.hpp"
#include "dist/distribute.hpp"
#include "mesh/adjacency.hpp"
#include "tests/support/dealt_cube.hpp"

namespace skein {
namespace {

using test::DealtCube;
using test::world;

constexpr int kWidth = 4;

/// Four linear fields; the second is constant.
std::array<double, kWidth> linear(Vec3 x) { return {1 + 2 * x.x - 3 * x.y + 0.5 * x.z, 7, x.x, 1e6 - x.z}; }

template <class F>
VertFields fields_at(const DistMesh& dist, F f) {
  VertFields d{kWidth, {}};
  for (const Vec3 x : dist.mesh.coords) {
    for (const double c : f(x)) d.values.push_back(c);
  }
  return d;
}

/// The cube with adjacency, its points moved by `place`.
template <class Move>
DistMesh moved(const Comm& comm, const DealtCube& cube, Move place) {
  DistMesh dist = cube.part(comm);
  build_adjacency(dist.mesh);
  for (Vec3& x : dist.mesh.coords) x = place(x);
  return dist;
}
DistMesh plain(const Comm& comm, const DealtCube& cube) {
  return moved(comm, cube, [](Vec3 x) { return x; });
}

/// Points all over the unit cube, others on every rank, in no order.
std::vector<Vec3> scattered(int n) {
  std::vector<Vec3> points;
  const double shift = 0.1 * num(world().rank());
  const auto fraction = [](double x) { return x - std::floor(x); };
  for (int i = 1; i <= n; ++i)
    points.push_back({fraction(i * 0.754877666 + shift), fraction(i * 0.569840291 + shift), fraction(i * 0.430159709)});
  return points;
}

void expect_linear(const std::vector<Vec3>& points, const VertFields& got) {
  EXPECT_EQ(got.values.size(), points.size() * kWidth);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto want = linear(points[i]);
    const double* have = got.at(to_id<VertId>(i));
    for (std::size_t c = 0; c < kWidth; ++c) EXPECT_NEAR(have[c], want[c], 1e-13 * std::max(10.0, std::abs(want[c])));
    EXPECT_EQ(have[1], 7);
  }
}

TEST(Transfer, linear_fields_are_exact_anywhere) {
  const DistMesh dist = plain(world(), DealtCube{9, 0.3});
  const Background old(world(), dist, fields_at(dist, linear));
  for (const int threads : {1, 3}) {
    const auto points = scattered(5000);
    TransferReport report;
    expect_linear(points, old.at(points, threads, &report));
    EXPECT_EQ(report.points, 5000 * world().size());
    EXPECT_EQ(report.outside, 0);
    EXPECT_EQ(report.remote > 0, world().size() > 1);
  }
}

TEST(Transfer, threads_do_not_change_a_bit) {
  const DistMesh dist = plain(world(), DealtCube{6, 0.3});
  const Background old(world(), dist, fields_at(dist, [](Vec3 x) {
                         return std::array<double, kWidth>{std::sin(9 * x.x), x.y * x.z, std::exp(x.z), 1};
                       }));
  const auto points = scattered(20000);
  EXPECT_EQ(old.at(points, 1).values, old.at(points, 4).values);
}

TEST(Transfer, old_vertices_keep_their_values_bit_by_bit) {
  const DistMesh dist = plain(world(), DealtCube{7, 0.3});
  const auto wild = [](Vec3 x) {
    return std::array<double, kWidth>{std::sin(1e3 * x.x), 1 / (0.1 + x.y), 1e-9 * x.z, std::cos(1e4 * (x.x + x.z))};
  };
  const VertFields fields = fields_at(dist, wild);
  const Background old(world(), dist, fields);
  EXPECT_EQ(old.at_vertices(dist).values, fields.values);
}

TEST(Transfer, ranks_without_tetrahedra_or_points_are_fine) {
  const DistMesh dist = plain(world(), DealtCube{1, 0});
  const Background old(world(), dist, fields_at(dist, linear));
  const auto points = scattered(num(world().rank()) + 1 == world().size() ? 200 : 0);
  expect_linear(points, old.at(points));
}

TEST(Transfer, points_outside_take_the_nearest_point) {
  const DistMesh dist = plain(world(), DealtCube{8, 0.2});
  const Background old(world(), dist, fields_at(dist, linear));
  auto points = scattered(500), nearest = points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3& x = points[i];
    x = 3.0 * x - Vec3{1, 1, 1};
    nearest[i] = {std::clamp(x.x, 0.0, 1.0), std::clamp(x.y, 0.0, 1.0), std::clamp(x.z, 0.0, 1.0)};
  }
  TransferReport report;
  expect_linear(nearest, old.at(points, 1, &report));
  double farthest = 0, inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    farthest = std::max(farthest, norm(points[i] - nearest[i]));
    inside += points[i] == nearest[i] ? 1 : 0;
  }
  EXPECT_NEAR(report.farthest, world().max(farthest), 1e-14);
  EXPECT_EQ(report.outside, report.points - static_cast<std::int64_t>(world().sum(inside)));
}

TEST(Transfer, on_a_curved_boundary_the_error_is_within_its_deviation) {
  // A quarter of a ring, radii 1 and 2: new points on the outer side leave the old mesh by its deviation.
  const auto ring = [](Vec3 x) {
    const double r = 1 + x.x, a = x.y * std::acos(0.0);
    return Vec3{r * std::cos(a), r * std::sin(a), x.z};
  };
  constexpr int kCells = 6;
  const DistMesh dist = moved(world(), DealtCube{kCells, 0}, ring),
                 fine = moved(world(), DealtCube{3 * kCells, 0}, ring);
  const Background old(world(), dist, fields_at(dist, linear));
  TransferReport report;
  const VertFields got = old.at_vertices(fine, 1, &report);
  const double deviation = 2 * (1 - std::cos(std::acos(0.0) / kCells / 2));
  EXPECT_GT(report.outside, 0);
  EXPECT_LE(report.farthest, deviation);
  EXPECT_GT(report.farthest, 0.5 * deviation);
  const double slope = std::sqrt(4 + 9 + 0.25);
  for (const VertId v : IdRange<VertId>(fine.mesh.vert_slots())) {
    EXPECT_NEAR(got.at(v)[0], linear(fine.mesh.coords[v])[0], slope * report.farthest * (1 + 1e-12));
    EXPECT_EQ(got.at(v)[1], 7);
    EXPECT_LE(got.at(v)[2], 2 + 1e-14);
    EXPECT_GE(got.at(v)[2], -1e-14);
  }
}

TEST(Transfer, fields_that_do_not_fit_are_refused_on_all_ranks) {
  const DistMesh dist = plain(world(), DealtCube{3, 0});
  VertFields fields = fields_at(dist, linear);
  if (world().is_root()) fields.values.pop_back();
  EXPECT_THROW(Background(world(), dist, fields), AgreedError);
}

/// The slices of a file with the cube.
MeshSlice cube_slices(const DealtCube& cube) {
  const DistMesh whole = cube.part(Comm::self());
  MeshSlice s;
  s.path = "cube";
  s.total_verts = whole.global_verts, s.tets.total = whole.global_tets;
  const Slice verts = even_slice(s.total_verts, world().rank(), world().size());
  const Slice tets = even_slice(s.tets.total, world().rank(), world().size());
  s.first_vert = verts.first, s.tets.first = tets.first;
  for (std::int64_t v = verts.first; v < verts.last; ++v) s.coords.push_back(whole.mesh.coords[to_id<VertId>(v)]);
  for (std::int64_t t = tets.first; t < tets.last; ++t) {
    std::array<GlobalId, 4> gids;
    for (std::size_t k = 0; k < 4; ++k) gids[k] = whole.vert2gid[whole.mesh.tet2vert[to_id<TetId>(t)][k]];
    s.tets.verts.push_back(gids);
  }
  s.vert_ref.assign(s.coords.size(), 0);
  s.tets.ref.assign(s.tets.verts.size(), 1);
  return s;
}

TEST(Transfer, after_adaptation_linear_fields_are_exact) {
  DistMesh dist = distribute(world(), cube_slices({4, 0.1}));
  const Background old(world(), dist, fields_at(dist, linear));
  for (const Vec3 x : dist.mesh.coords) dist.mesh.log_metric.push_back(isotropic(-2 * std::log(0.05 + 0.15 * x.x)));
  PhaseLog log(world(), PhaseLog::Output::kQuiet);
  adapt(world(), dist, {}, log);
  TransferReport report;
  expect_linear(dist.mesh.coords.raw(), old.at_vertices(dist, 1, &report));
  EXPECT_LE(report.farthest, 1e-14);
}

}  // namespace
}  // namespace skein
