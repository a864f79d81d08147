// Vertices that several ranks have: sums over their copies.
#pragma once
#include <mpi.h>

#include <cstdint>
#include <vector>

class SharedVertices {
 public:
  /// Collective. Every rank tells all others which vertices it has: simple, and good enough for a few ranks.
  SharedVertices(MPI_Comm comm, const std::vector<std::int64_t>& local2global);

  /// Collective. values: one per local vertex. Every copy of a shared vertex gets the sum of all copies, added in the
  /// order of the ranks, so that all get the same bits.
  void sum(std::vector<double>& values) const;

 private:
  MPI_Comm comm_;
  int rank_ = 0;
  std::vector<std::vector<int>> shared_;  ///< by rank: local vertices that it has, too, in an order that both know
};
