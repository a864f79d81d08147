// A result that the end check has found wrong is written beside the output, which stays as it was.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "api/adaptation.hpp"
#include "app/run_report.hpp"
#include "comm/file.hpp"
#include "io/mesh_io.hpp"
#include "tests/support/dist_meshes.hpp"
#include "tests/support/world.hpp"

namespace skein::test {
namespace {

TEST(Suspect, Path) {
  EXPECT_EQ(app::suspect_path("out.mesh"), "out.suspect.mesh");
  EXPECT_EQ(app::suspect_path("a.b/c.d.meshb"), "a.b/c.d.suspect.meshb");
  EXPECT_EQ(app::suspect_path("/x/out.pvtu"), "/x/out.suspect.pvtu");
}

TEST(Suspect, IsWrittenAndTheRunEndsWithCode5) {
  const Comm& comm = world();
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("skein-suspect-{}", comm.size());
  if (comm.is_root()) std::filesystem::create_directories(folder);
  comm.barrier();
  const std::string out = folder / "out.mesh";
  const DistMesh input = distribute(comm, slices(comm, cube(2)));
  DistMesh wrong = distribute(comm, slices(comm, cube(2)));
  for (Vec3& x : wrong.mesh.coords) x.x *= 2;
  AdaptationOptions options;
  options.suspect = [&](DistMesh&& dist) { app::write_suspect(comm, out, std::move(dist)); };
  ExitCode code = ExitCode::kOk;
  try {
    end_check(comm, invariants(comm, input), wrong, options);
  } catch (const AgreedError& e) {
    code = e.code();
  }
  EXPECT_EQ(code, ExitCode::kInternal);
  EXPECT_FALSE(std::filesystem::exists(out));
  const MeshSlice written = read_mesh(comm, folder / "out.suspect.mesh");
  EXPECT_EQ(written.tets.total, 48);
  EXPECT_EQ(comm.max(written.coords.empty() ? 0 : written.coords.back().x), 2);
  comm.barrier();
  if (comm.is_root()) std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace skein::test
