// Band: the active tetrahedra of a rank and what lies next to them, cut out of the rank's mesh and put back.
#pragma once
#include <span>
#include <vector>

#include "dist/dist_mesh.hpp"
#include "kernel/part.hpp"
#include "mesh/surroundings.hpp"

namespace skein {

/// A piece of a rank's mesh, as a mesh of its own. Vertices that the rest of the mesh may have, too, are kFrozen.
struct Band {
  TetMesh mesh;
  std::vector<TetId> tets;            ///< the rank's numbers of its tetrahedra, ascending
  IdVector<VertId, VertId> to_rank;   ///< the rank's number of each vertex as it was cut
  std::vector<FaceId> seam;           ///< faces of the rank's other tetrahedra that are neighbours of the band
  std::vector<FeatureEdge> features;  ///< the rank's feature edges that are edges of the band
};

/// Cuts out all tetrahedra at the vertices of `near`, in their order, with all columns; there, of the kActive vertices
/// only those of `near` are active. The column metric is made from log_metric if the mesh has it not. The mesh stays as
/// it is. The cost grows with the band, but for two bytes per tetrahedron and vertex. Not collective. @pre the mesh is
/// compact, and has log_metric
Band cut_band(const TetMesh& mesh, Surroundings near, int threads);
/// The same within `layers` edges of all kActive vertices; only these are active.
Band cut_band(const TetMesh& mesh, int layers, int threads = 1);

/// Puts an adapted band in the place of the one that was cut. `old2new` follows the band's vertices that were frozen
/// (adapt_local). The columns that the mesh has come from the band, but frozen vertices keep theirs, up to what the
/// work has told about them (kBesideFrozen, kRetry). The result is compact; numbers that are free are filled from the
/// end, and the vertices `kept` are followed. Not collective. @pre the mesh is as it was when the band was cut; the
/// band is compact.
void put_back(TetMesh& mesh, const Band& band, const IdVector<VertId, VertId>& old2new, std::span<VertId> kept,
              int threads);
/// The same in a rank's mesh: vertices of the rest and frozen ones keep their global ids, all others get kNoGlobal;
/// dist.sharing follows.
void put_back(DistMesh& dist, const Band& band, const IdVector<VertId, VertId>& old2new, int threads = 1);

}  // namespace skein
