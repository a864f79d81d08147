// Adapting on a reference surface.
#pragma once
#include <functional>
#include <optional>

#include "api/adaptation.hpp"

namespace skein {

/// Collective. Makes the reference surface from the boundary of `geometry`, or of the mesh itself where that is empty,
/// does the `work` with it (options whose adapt.reference is that surface), and tells how far the new boundary is off.
/// `before` gets what areas and volumes gain where the boundary follows the curved surface.
std::optional<SurfaceReport> adapt_on_surface(const Comm& comm, DistMesh& dist, const MeshSlice& geometry,
                                              const AdaptationOptions& options, PhaseLog& log, Invariants& before,
                                              const std::function<void(const AdaptationOptions&)>& work);

}  // namespace skein
