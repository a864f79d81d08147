// A unit cube of n^3 cells, six tetrahedra each, dealt to ranks so that some vertices are on three and more of them.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "dist/dist_mesh.hpp"
#include "tests/support/whole_mesh.hpp"
#include "tests/support/world.hpp"

namespace skein::test {

struct DealtCube {
  int n;         ///< cells per side
  double shake;  ///< inner vertices move by up to this part of a cell

  /// How many cells the vertex is away from the hull.
  [[nodiscard]] int depth(std::int64_t g) const {
    const auto c = Lattice{n}.place(g);
    int d = n;
    for (const int x : c) d = std::min({d, x, n - x});
    return d;
  }
  [[nodiscard]] Vec3 coords(std::int64_t g) const {
    const auto c = Lattice{n}.place(g);
    const double h = 1.0 / n;
    const double m = depth(g) > 0 ? shake * h : 0;
    const auto move = [&](double seed) { return m * std::sin(seed * static_cast<double>(g + 1)); };
    return {c[0] * h + move(12.9898), c[1] * h + move(78.233), c[2] * h + move(37.719)};
  }
  /// Columns of cells by quadrant, so that up to four ranks meet at the middle line.
  [[nodiscard]] int owner(int i, int j, int ranks) const { return (2 * i / n + 2 * (2 * j / n)) % ranks; }

  /// The part of comm's rank (the whole mesh for Comm::self()).
  [[nodiscard]] DistMesh part(const Comm& comm) const;
};

/// The values of f(position) at the local vertices.
template <class F>
std::vector<double> sample(const DistMesh& dist, F f) {
  std::vector<double> out;
  for (const Vec3 x : dist.mesh.coords) out.push_back(f(x));
  return out;
}

inline DistMesh DealtCube::part(const Comm& comm) const {
  const int self = num(comm.rank());
  std::map<std::int64_t, std::set<int>> gid2ranks;
  std::vector<std::array<std::int64_t, 4>> tets;
  const WholeMesh whole = cells(n);
  for (std::size_t t = 0; t < whole.tets.size(); ++t) {
    const auto cell = static_cast<int>(t / 6);
    const int rank = owner(cell % n, cell / n % n, comm.size());
    for (const auto g : whole.tets[t]) gid2ranks[g].insert(rank);
    if (rank == self) tets.push_back(whole.tets[t]);
  }
  DistMesh dist;
  std::map<std::int64_t, VertId> gid2vert;
  for (const auto& [g, ranks] : gid2ranks) {
    if (!ranks.contains(self)) continue;
    const VertId v = dist.mesh.coords.push_back(coords(g));
    gid2vert[g] = v;
    dist.vert2gid.push_back(GlobalId{g});
    if (ranks.size() == 1) continue;
    dist.sharing.vert.push_back(v);
    dist.sharing.gid.push_back(GlobalId{g});
    for (const int r : ranks) {
      if (r != self) dist.sharing.rank.push_back(Rank{r});
    }
    dist.sharing.offset.push_back(dist.sharing.rank.size());
  }
  for (const auto& t : tets) {
    std::array<VertId, 4> verts;
    std::array<FaceTag, 4> tags{};
    for (std::size_t k = 0; k < 4; ++k) verts[k] = gid2vert.at(t[k]);
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& k = kFaceVerts[f];
      const auto& x = whole.coords;
      if (side_of_cube(std::array{x[t[k[0]]], x[t[k[1]]], x[t[k[2]]]}) >= 0) tags[f] = kHullFace | 1;
    }
    dist.mesh.tet2vert.push_back(verts);
    dist.mesh.face_tag.push_back(tags);
  }
  dist.global_verts = static_cast<std::int64_t>(gid2ranks.size());
  dist.global_tets = 6 * static_cast<std::int64_t>(n) * n * n;
  return dist;
}

}  // namespace skein::test
