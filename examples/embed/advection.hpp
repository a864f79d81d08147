// Advection of a density by a constant velocity: finite volumes round the vertices (median dual), first-order upwind,
// explicit steps. Walls on all sides, so that nothing is lost.
#pragma once
#include <mpi.h>

#include <array>
#include <skein/skein.hpp>
#include <vector>

#include "shared_vertices.hpp"

class Advection {
 public:
  /// Collective.
  Advection(MPI_Comm comm, const skein::PartitionedMesh& mesh, std::array<double, 3> velocity);

  /// Collective. Goes on for this time; density: one value per local vertex.
  void advance(std::vector<double>& density, double duration) const;

  /// Collective. The integral of the density, linear in each tetrahedron.
  [[nodiscard]] double mass(const std::vector<double>& density) const;

 private:
  /// The volume that goes through a face between two dual cells, per time.
  struct Flow {
    int from, to;
    double rate;
  };

  MPI_Comm comm_;
  SharedVertices shared_;
  std::vector<Flow> flows_;          ///< of the local tetrahedra
  std::vector<double> own_volume_;   ///< of the dual cells, from the local tetrahedra
  std::vector<double> full_volume_;  ///< from those of all ranks
  double step_ = 0;                  ///< the longest stable one, with a margin
};
