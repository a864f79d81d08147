// The only file that knows TetGen.
#include "generate/tetgen_volume.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "base/error.hpp"
#include "mesh/predicates.hpp"

#ifdef SKEIN_WITH_TETGEN
// TetGen ends through terminatetetgen(), which frees what its destructor then frees again: an error would crash. The
// library calls it through the symbol table, so that the version below takes the place of its own: it must be visible.
#define terminatetetgen terminatetetgen_that_frees_twice
#include <tetgen.h>
#undef terminatetetgen
[[gnu::visibility("default")]] void terminatetetgen(tetgenmesh*, int code) { throw code; }
#endif

namespace skein {

#ifndef SKEIN_WITH_TETGEN

bool has_tetgen() noexcept { return false; }

Volume fill_volume(const ClosedSurface&, const std::vector<Vec3>&) {
  throw Error(
      ExitCode::kUsage,
      "volume generation needs TetGen, which this build lacks: install it (Debian: libtet1.5-dev) and configure "
      "with -DSKEIN_WITH_TETGEN=ON");
}

#else

bool has_tetgen() noexcept { return true; }

namespace {

/// TetGen's exit numbers.
enum TetgenExit : int { kOutOfMemory = 1, kSelfIntersection = 3, kSmallFeature = 4, kCloseFacets = 5 };

// NOLINTBEGIN(cppcoreguidelines-owning-memory): ~tetgenio frees these arrays
void set_input(const MeshSlice& mesh, const std::vector<Vec3>& seeds, const std::vector<Vec3>& holes, tetgenio& in) {
  in.numberofpoints = static_cast<int>(mesh.coords.size() + seeds.size());
  in.pointlist = new double[3 * static_cast<std::size_t>(in.numberofpoints)];
  double* p = in.pointlist;
  for (const auto* points : {&mesh.coords, &seeds}) {
    for (const Vec3 x : *points) {
      *p++ = x.x;
      *p++ = x.y;
      *p++ = x.z;
    }
  }
  const auto& triangles = mesh.triangles.verts;
  in.numberoffacets = static_cast<int>(triangles.size());
  in.facetlist = new tetgenio::facet[triangles.size()];
  in.facetmarkerlist = new int[triangles.size()];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    tetgenio::facet& f = in.facetlist[t];
    tetgenio::init(&f);
    f.numberofpolygons = 1;
    f.polygonlist = new tetgenio::polygon[1];
    f.polygonlist[0].numberofvertices = 3;
    f.polygonlist[0].vertexlist = new int[3];
    for (std::size_t k = 0; k < 3; ++k) f.polygonlist[0].vertexlist[k] = static_cast<int>(num(triangles[t][k]));
    in.facetmarkerlist[t] = static_cast<int>(t) + 1;
  }
  in.numberofholes = static_cast<int>(holes.size());
  if (holes.empty()) return;
  in.holelist = new double[3 * holes.size()];
  for (std::size_t h = 0; h < holes.size(); ++h) {
    in.holelist[3 * h] = holes[h].x;
    in.holelist[3 * h + 1] = holes[h].y;
    in.holelist[3 * h + 2] = holes[h].z;
  }
}
// NOLINTEND(cppcoreguidelines-owning-memory)

tetgenbehavior behaviour() {
  tetgenbehavior b;
  b.object = tetgenbehavior::POLY;
  b.plc = 1;
  b.quiet = 1;
  b.nobisect = 1;      // no point on the boundary
  b.nomergefacet = 1;  // every surface triangle stays, also among coplanar ones
  b.nomergevertex = 1;
  b.nojettison = 1;  // point numbers stay
  b.zeroindex = 1;
  return b;
}

/// TetGen, with standard output closed to it: some of its lines come even when it shall be quiet.
void run_tetgen(tetgenbehavior& b, tetgenio& in, tetgenio& out) {
  std::fflush(stdout);
  const int kept = ::dup(STDOUT_FILENO), nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (kept >= 0 && nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO);
  const auto restore = [&] {
    std::fflush(stdout);
    if (kept >= 0 && nowhere >= 0) ::dup2(kept, STDOUT_FILENO);
    for (const int fd : {kept, nowhere}) {
      if (fd >= 0) ::close(fd);
    }
  };
  try {
    tetrahedralize(&b, &in, &out);
  } catch (...) {
    restore();
    throw;
  }
  restore();
}

/// Triangles (1-based) that cut each other, from TetGen's diagnosis; empty when it finds none.
std::vector<int> intersecting(const MeshSlice& mesh) {
  tetgenio in, out;
  set_input(mesh, {}, {}, in);
  tetgenbehavior b = behaviour();
  b.diagnose = 1;
  try {
    run_tetgen(b, in, out);
  } catch (int) {
    return {};
  }
  std::vector<int> numbers;
  for (int i = 0; i < out.numberoftrifaces && out.trifacemarkerlist != nullptr; ++i) {
    numbers.push_back(out.trifacemarkerlist[i]);
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

[[noreturn]] void explain(int code, const MeshSlice& mesh) {
  const std::string path = mesh.path.empty() ? "surface" : mesh.path;
  if (code == kOutOfMemory) throw Error(ExitCode::kInternal, fmt::format("{}: TetGen ran out of memory", path));
  const std::vector<int> cut = intersecting(mesh);
  if (!cut.empty()) {
    constexpr std::size_t kShown = 6;
    const std::size_t n = std::min(kShown, cut.size());
    throw Error(ExitCode::kInvalidMesh,
                fmt::format("{}: the surface cuts itself: triangles {}{} ({} in all) cross or overlap others", path,
                            fmt::join(cut.begin(), cut.begin() + static_cast<std::ptrdiff_t>(n), ", "),
                            n < cut.size() ? ", ..." : "", cut.size()));
  }
  if (code == kSelfIntersection || code == kSmallFeature || code == kCloseFacets) {
    throw Error(
        ExitCode::kInvalidMesh,
        fmt::format("{}: parts of the surface cut or nearly touch each other; make them meet or separate them", path));
  }
  throw Error(ExitCode::kInvalidMesh, fmt::format("{}: TetGen could not fill this surface (its error {})", path, code));
}

Volume take_output(const MeshSlice& mesh, std::size_t seeds, const tetgenio& out) {
  const std::size_t surface_verts = mesh.coords.size();
  std::vector<GlobalId> number(static_cast<std::size_t>(out.numberofpoints), kNoGlobal);
  for (int i = 0; i < 4 * out.numberoftetrahedra; ++i) number[out.tetrahedronlist[i]] = GlobalId{0};
  Volume volume;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (v < surface_verts) {
      number[v] = to_id<GlobalId>(v);
    } else if (number[v] != kNoGlobal) {  // seeds outside the domain are in no tetrahedron
      number[v] = to_id<GlobalId>(surface_verts + volume.added.size());
      volume.added.push_back({out.pointlist[3 * v], out.pointlist[3 * v + 1], out.pointlist[3 * v + 2]});
      volume.added_is_seed.push_back(v < surface_verts + seeds ? 1 : 0);
    }
  }
  const auto coords = [&](GlobalId v) {
    return idx(v) < surface_verts ? mesh.coords[idx(v)] : volume.added[idx(v) - surface_verts];
  };
  volume.tets.reserve(static_cast<std::size_t>(out.numberoftetrahedra));
  for (int t = 0; t < out.numberoftetrahedra; ++t) {
    const int* v = out.tetrahedronlist + static_cast<std::ptrdiff_t>(t) * out.numberofcorners;
    std::array<GlobalId, 4> tet;
    for (std::size_t k = 0; k < 4; ++k) tet[k] = number[v[k]];
    if (orient3d_sign(coords(tet[0]), coords(tet[1]), coords(tet[2]), coords(tet[3])) < 0) std::swap(tet[2], tet[3]);
    volume.tets.push_back(tet);
  }
  return volume;
}

/// Throws unless the faces with one tetrahedron are the surface triangles.
void check_boundary(const MeshSlice& mesh, const Volume& volume) {
  using Face = std::array<GlobalId, 3>;
  std::vector<Face> faces;
  faces.reserve(4 * volume.tets.size());
  constexpr std::size_t kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (const auto& tet : volume.tets) {
    for (const auto& f : kFace) {
      Face face{tet[f[0]], tet[f[1]], tet[f[2]]};
      std::sort(face.begin(), face.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end());
  std::vector<Face> hull;
  for (std::size_t i = 0, end = 0; i < faces.size(); i = end) {
    while (end < faces.size() && faces[end] == faces[i]) ++end;
    if (end - i == 1) hull.push_back(faces[i]);
  }
  std::vector<Face> wanted(mesh.triangles.verts.begin(), mesh.triangles.verts.end());
  for (Face& face : wanted) std::sort(face.begin(), face.end());
  std::sort(wanted.begin(), wanted.end());
  if (hull == wanted) return;
  throw Error(
      ExitCode::kInvalidMesh,
      fmt::format("{}: TetGen could not keep the surface triangulation ({} triangles, {} boundary faces after); "
                  "improve its worst triangles",
                  mesh.path.empty() ? "surface" : mesh.path, wanted.size(), hull.size()));
}

}  // namespace

Volume fill_volume(const ClosedSurface& surface, const std::vector<Vec3>& seeds) {
  const MeshSlice& mesh = surface.mesh;
  if (mesh.coords.size() + seeds.size() > static_cast<std::size_t>(std::numeric_limits<int>::max() / 4) ||
      mesh.triangles.verts.size() > static_cast<std::size_t>(std::numeric_limits<int>::max() / 4)) {
    throw Error(ExitCode::kInvalidMesh, "the surface is too large for TetGen's 32-bit numbers");
  }
  tetgenio in, out;
  set_input(mesh, seeds, surface.voids, in);
  tetgenbehavior b = behaviour();
  try {
    run_tetgen(b, in, out);
  } catch (int code) {
    explain(code, mesh);
  }
  if (out.numberoftetrahedra == 0) explain(0, mesh);
  Volume volume = take_output(mesh, seeds.size(), out);
  check_boundary(mesh, volume);
  return volume;
}

#endif

}  // namespace skein
