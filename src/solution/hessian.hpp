// Second derivatives of a solution at the vertices, recovered in parallel.
#pragma once
#include <span>
#include <vector>

#include "base/tensor.hpp"
#include "comm/halo.hpp"
#include "dist/dist_mesh.hpp"

namespace skein {

/// Collective. The gradient at every local vertex: the volume-weighted mean of the gradients of its tetrahedra, that is
/// the weighted-residual recovery with lumped mass [HassanProbert1999, 35.3.3]. Exact for linear functions. scalar: one
/// value per local vertex, equal on all copies. Result: per local vertex, the same bits on all copies; unit of the
/// scalar / length.
std::vector<Vec3> recover_gradient(const Comm& comm, const DistMesh& dist, const Halo& halo,
                                   std::span<const double> scalar);

/// Collective. The Hessian at every local vertex: the recovery applied twice, made symmetric
/// [HassanProbert1999, 35.3.3]. Hull vertices have tetrahedra on one side only. There the gradient is first corrected
/// from the inner neighbours (quadratic along each edge), and the Hessian is the weighted mean of the Hessians of the
/// inner neighbours (or, if there are none, of hull vertices that had some). Without the correction the Hessian in the
/// first inner layer would be wrong by a quarter. Exact for linear functions, and for quadratic ones at vertices whose
/// first two rings are symmetric about them. Throws Error(kInput) on all ranks when a value is not finite (vertex
/// number 1-based, global).
/// @pre scalar.size() == dist.mesh.vert_slots(); `halo` is that of dist.sharing.
std::vector<SymTensor> recover_hessian(const Comm& comm, const DistMesh& dist, const Halo& halo,
                                       std::span<const double> scalar);

}  // namespace skein
