// Cutting a band out of a rank's mesh and putting it back: nothing is lost, whatever is done to the band in between.
#include "adapt/band.hpp"

#include <gtest/gtest.h>

#include "adapt/local.hpp"
#include "base/tensor.hpp"
#include "dist/interface.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

/// A cube of two regions on all ranks that asks for the edge length h; active where x < 0.4.
DistMesh make(const Comm& comm, double h) {
  DistMesh dist = with_metric(comm, cube(10, Regions::kTwoTagged), [&](Vec3) { return isotropic(-2 * std::log(h)); });
  for (const VertId v : IdRange<VertId>(dist.mesh.vert_slots())) {
    if (dist.mesh.coords[v].x < 0.4) dist.mesh.vert_state[v] |= kActive;
  }
  return dist;
}

/// Collective. The corners' coordinates of the tetrahedra at x >= `from`, of all ranks.
Items tets_beyond(const Comm& comm, DistMesh& dist, double from) {
  Items out;
  for (const auto& item : content(comm, to_slices(comm, dist)).tets) {
    if (item[0] >= from && item[3] >= from && item[6] >= from && item[9] >= from) out.push_back(item);
  }
  return out;
}

TEST(Band, ComesBackAsItWasCut) {
  const Comm& comm = world();
  for (const int threads : {1, 3}) {
    DistMesh dist = make(comm, 0.1);
    const Content before = content(comm, to_slices(comm, dist));
    const Band band = cut_band(dist.mesh, 1, threads);
    EXPECT_EQ(check(band.mesh), "");
    EXPECT_LT(band.mesh.tet_slots(), dist.mesh.tet_slots() + (comm.size() > 1 ? 1 : 0));
    IdVector<VertId, VertId> old2new(band.mesh.vert_slots(), kNoVert);
    for (const VertId v : IdRange<VertId>(old2new.size())) old2new[v] = band.mesh.has(v, kFrozen) ? v : kNoVert;
    put_back(dist, band, old2new, threads);
    number_new_vertices(comm, dist);
    EXPECT_NO_THROW(reconcile(comm, dist));
    EXPECT_EQ(check(dist.mesh), "");
    EXPECT_EQ(content(comm, to_slices(comm, dist)), before);
  }
}

TEST(Band, BringsBackRetryVertices) {
  const Comm& comm = world();
  DistMesh dist = make(comm, 0.1);
  for (VertState& s : dist.mesh.vert_state) s |= kRetry;
  Band band = cut_band(dist.mesh, 1);
  const auto marked = [](Vec3 x) { return x.y < 0.5; };  // as the kernel would, on frozen vertices, too
  for (const VertId v : IdRange<VertId>(band.mesh.vert_slots())) {
    if (!marked(band.mesh.coords[v])) band.mesh.vert_state[v] &= ~kRetry;
  }
  IdVector<VertId, VertId> old2new(band.mesh.vert_slots(), kNoVert);
  for (const VertId v : IdRange<VertId>(old2new.size())) old2new[v] = band.mesh.has(v, kFrozen) ? v : kNoVert;
  IdVector<VertId, char> in_band(dist.mesh.vert_slots(), 0);
  for (const VertId v : band.to_rank) in_band[v] = 1;
  put_back(dist, band, old2new);  // nothing has changed, so numbers have not
  for (const VertId v : IdRange<VertId>(in_band.size())) {
    EXPECT_EQ(dist.mesh.has(v, kRetry), in_band[v] == 0 || marked(dist.mesh.coords[v]));
  }
}

TEST(Band, MayGrowAndShrink) {
  const Comm& comm = world();
  for (const double h : {0.04, 0.25}) {
    SCOPED_TRACE(h);
    DistMesh dist = make(comm, h);
    const Measure before = measure(comm, dist);
    const Items rest = tets_beyond(comm, dist, 0.75);
    const std::int64_t tets = dist.global_tets;
    constexpr int kMargin = 2;  // of cells of 0.1: nothing beyond 0.4 + 0.3 belongs to the band
    const int threads = h < 0.1 ? 3 : 2;
    Band band = cut_band(dist.mesh, kMargin, threads);
    const LocalResult r = adapt_local(band.mesh, {});
    put_back(dist, band, r.old2new, threads);
    number_new_vertices(comm, dist);
    EXPECT_NO_THROW(reconcile(comm, dist));
    EXPECT_EQ(check(dist.mesh), "");
    const Measure after = measure(comm, dist);
    EXPECT_NEAR(after.volume, before.volume, 1e-12);
    EXPECT_NEAR(after.feature_length, before.feature_length, 1e-11);
    for (const auto& [ref, area] : before.area) EXPECT_NEAR(after.area.at(ref), area, 1e-11) << "patch " << ref;
    EXPECT_EQ(tets_beyond(comm, dist, 0.75), rest);
    EXPECT_EQ(dist.global_tets > tets, h < 0.1);
  }
}

TEST(Band, IsEmptyWhereNothingIsActive) {
  const Comm& comm = world();
  DistMesh dist = make(comm, 0.1);
  for (VertState& s : dist.mesh.vert_state) s &= ~kActive;
  const Content before = content(comm, to_slices(comm, dist));
  Band band = cut_band(dist.mesh, 2);
  EXPECT_EQ(band.mesh.tet_slots(), 0u);
  const LocalResult r = adapt_local(band.mesh, {});
  put_back(dist, band, r.old2new);
  EXPECT_NO_THROW(reconcile(comm, dist));
  EXPECT_EQ(content(comm, to_slices(comm, dist)), before);
}

}  // namespace
}  // namespace skein::test
