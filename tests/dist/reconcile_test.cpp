// reconcile(): passes on a good mesh, and fails on all ranks for every single corruption.
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

DistMesh make(const Comm& comm) {
  const MeshSlice file = slices(comm, cube(4));
  const FieldSlice field = fields(file);
  return distribute(comm, file, &field, {.metric_first = true});
}

/// Damages rank 0's part; every rank must get the error, and the line must have `word`.
void expect_fault(const std::function<void(DistMesh&)>& damage, const std::string& word) {
  const Comm& comm = world();
  DistMesh dist = make(comm);
  if (comm.is_root()) damage(dist);
  try {
    reconcile(comm, dist);
    ADD_FAILURE() << "passed in spite of: " << word;
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInternal);
    EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
  }
}

FaceId first_face(const TetMesh& m, bool hull) {
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto s = static_cast<std::size_t>(k);
      if (m.tet2face[t][s] == kNoFace && is_hull(m.face_tag[t][s]) == hull) return make_face(t, k);
    }
  }
  return kNoFace;
}

/// The neighbours of two faces change places: each is still named once, but names another face.
void swap_two_neighbours(TetMesh& m) {
  std::vector<FaceId*> found;
  for (auto& faces : m.tet2face) {
    for (FaceId& f : faces) {
      if (f != kNoFace && found.size() < 2) found.push_back(&f);
    }
  }
  std::swap(*found.at(0), *found.at(1));
}

TEST(Reconcile, PassesOnAGoodMesh) {
  const Comm& comm = world();
  EXPECT_NO_THROW(reconcile(comm, make(comm)));
}

TEST(Reconcile, SeesWhatIsWrongOnOneRank) {
  expect_fault([](DistMesh& d) { d.mesh.tet2face[TetId{3}][1] = make_face(TetId{3}, 2); }, "name it back");
  expect_fault([](DistMesh& d) { d.mesh.tet2face[TetId{3}][1] = make_face(TetId{3}, 1); }, "name it back");
  expect_fault([](DistMesh& d) { d.mesh.tet2face[TetId{3}][1] = make_face(d.mesh.tet2vert.end_id(), 0); }, "name it");
  expect_fault([](DistMesh& d) { swap_two_neighbours(d.mesh); }, "name it back");
  expect_fault([](DistMesh& d) { ++d.global_tets; }, "tetrahedra");
  expect_fault([](DistMesh& d) { d.vert2gid[VertId{0}] = d.vert2gid[VertId{1}]; }, "");
  expect_fault([](DistMesh& d) { d.mesh.vert_ref.push_back(0); }, "length");
}

TEST(Reconcile, SeesWhatDiffersBetweenRanks) {
  if (world().size() == 1) return;
  expect_fault([](DistMesh& d) { d.mesh.coords[d.sharing.vert[0]].x += 1e-15; }, "coordinates");
  expect_fault([](DistMesh& d) { d.mesh.log_metric[d.sharing.vert[2]].xz = -0.0; }, "data");
  expect_fault(
      [](DistMesh& d) {
        VertClass& c = d.mesh.vert_class[d.sharing.vert[0]];
        c = any(c & kCorner) ? c & ~kCorner : c | kCorner;
      },
      "flags");
  expect_fault(
      [](DistMesh& d) {
        const FaceId f = first_face(d.mesh, false);
        d.mesh.tag(f) = kHullFace | 1;
      },
      "face");
  expect_fault(
      [](DistMesh& d) {
        const FaceId f = first_face(d.mesh, true);
        d.mesh.tag(f) = 0;
      },
      "");
  expect_fault(
      [](DistMesh& d) {
        const FaceId f = first_face(d.mesh, false);
        auto& v = d.mesh.tet2vert[face_tet(f)];
        const auto s = face_side(f);
        std::swap(v[(s + 1) % 4], v[(s + 2) % 4]);
      },
      "");
  expect_fault(
      [](DistMesh& d) {
        d.sharing.vert.pop_back();
        d.sharing.gid.pop_back();
        d.sharing.offset.pop_back();
        d.sharing.rank.resize(d.sharing.offset.back());
      },
      "shar");
}

}  // namespace
}  // namespace skein::test
