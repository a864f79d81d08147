// The first mesh: the unit cube, n x n x n cells of six tetrahedra, in slabs.
#pragma once
#include <mpi.h>

#include <skein/skein.hpp>

/// This rank's slab of the cube. Its boundary has no triangles; Skein finds it, and its ridges and corners.
inline skein::PartitionedMesh cube(MPI_Comm comm, std::int64_t n) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const std::int64_t bottom = n * rank / ranks, top = n * (rank + 1) / ranks, row = n + 1, layer = row * row;
  skein::PartitionedMesh mesh;
  for (std::int64_t k = bottom; k <= top; ++k) {
    for (std::int64_t j = 0; j <= n; ++j) {
      for (std::int64_t i = 0; i <= n; ++i) {
        mesh.coords.push_back({double(i) / double(n), double(j) / double(n), double(k) / double(n)});
        mesh.local2global.push_back(i + row * j + layer * k);
      }
    }
  }
  // From one corner of a cell to the opposite one there are six ways along its edges, and each is a tetrahedron.
  const std::int64_t step[3] = {1, row, layer};
  constexpr int kWays[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (std::int64_t k = 0; k < top - bottom; ++k) {
    for (std::int64_t j = 0; j < n; ++j) {
      for (std::int64_t i = 0; i < n; ++i) {
        const std::int64_t a = i + row * j + layer * k;
        for (int way = 0; way < 6; ++way) {
          auto b = static_cast<std::int32_t>(a + step[kWays[way][0]]);
          auto c = static_cast<std::int32_t>(b + step[kWays[way][1]]);
          const auto d = static_cast<std::int32_t>(c + step[kWays[way][2]]);
          if (way >= 3) std::swap(b, c);  // odd ways have the other orientation
          mesh.tets.push_back({static_cast<std::int32_t>(a), b, c, d});
        }
      }
    }
  }
  return mesh;
}
