// Steps towards a metric that asks for elements far more stretched than those of the mesh.
#pragma once
#include <span>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "kernel/method.hpp"

namespace skein {

/// How far the metric is from the shapes that the mesh has. An element is *stretched* when the metric asks for many
/// pieces of it in one direction and for far fewer, or for none, in the others: points along its few long edges then
/// find no place that is far enough from all others, and all of them end in the same few shells.
struct StretchToDo {
  double elements = 0;  ///< predicted in the place of elements that are stretched beyond a bound
  double share = 0;     ///< of all that are predicted
  double excess = 0;    ///< logarithm of what is beyond the bound, on average over all that are predicted
};

/// Collective. `elements`: predicted for each local tetrahedron (predicted_elements). What is stretched more than
/// `bound` and more than `bound` edges long. @pre dist.mesh.metric is there
StretchToDo stretch_to_do(const Comm& comm, const DistMesh& dist, std::span<const double> elements, double bound);

/// Collective. Replaces the log-metric by a coarser one where it asks for more than `method.stretch_left` edges out of
/// one: there no direction gets more than `method.stretch_step`, or than this times what each other direction gets.
/// Directions in which the mesh gets coarser are left as they are: that comes first, as it makes room for the points of
/// the next steps.
void bound_stretch(const Comm& comm, DistMesh& dist, const Method::Growth& method);

}  // namespace skein
