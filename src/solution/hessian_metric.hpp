// The metric that equidistributes the interpolation error of a solution, at a given complexity.
#pragma once
#include <limits>
#include <span>

#include "base/tensor.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. The metric of least interpolation error in the L^p norm (p >= 1, also infinity) at this complexity:
/// M = s det(|H|)^(-1/(2p+3)) |H|, its sizes clamped to [h_min, h_max] and its aspect ratio (longest over shortest
/// size) to max_aspect; s is found so that the complexity is met with the clamps [LoseilleAlauzet2011]. With p =
/// infinity this is the sizing sqrt(C/|e|) of [HassanProbert1999, eq. 35.16, 35.17]. Returns the complexity reached:
/// the nearest possible one, when the clamps do not allow the wanted one. hessian, metric: one per local vertex; equal
/// on all copies, and so is the result. Where the Hessian vanishes,
/// its eigenvalues count as 1e-16 of the largest one of all vertices; there h_max is the bound in practice. Throws
/// Error(kInput) on all ranks for options out of range or a Hessian that is not finite.
/// @pre 0 <= h_min <= h_max, h_max may be infinity; complexity > 0.
double hessian_metric(const Comm& comm, const DistMesh& dist, double complexity, double p, double h_min, double h_max,
                      std::span<const SymTensor> hessian, std::span<SymTensor> metric, double max_aspect = 1e4);

}  // namespace skein
