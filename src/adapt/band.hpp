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
  MetricField metric;
  std::vector<TetId> tets;            ///< the rank's numbers of its tetrahedra, ascending
  IdVector<VertId, VertId> to_rank;   ///< the rank's number of each vertex as it was cut
  std::vector<FaceId> seam;           ///< faces of the rank's other tetrahedra that are neighbours of the band
  std::vector<FeatureEdge> features;  ///< the rank's feature edges that are edges of the band
};

/// What goes with the vertices of the mesh that a band is cut from.
class VertexAttributes {
 public:
  virtual ~VertexAttributes() = default;
  /// Gives the vertices of a field, from `first` on, the metrics of the vertices `from`. Several threads may call it at
  /// once.
  virtual void copy_metrics(std::span<const VertId> from, MetricField& field, VertId first) const = 0;
  virtual void reserve(std::size_t n) = 0;
  virtual void resize(std::size_t n) = 0;
  /// Vertex `to` is a new one now, with the metric of vertex `from` of the band.
  virtual void set(VertId to, const MetricField& metric, VertId from) = 0;
  /// Vertex `from` has got the number `to`.
  virtual void move(VertId from, VertId to) = 0;
  /// Numbers of vertices that shall follow when vertices get other numbers.
  virtual std::span<VertId> kept() = 0;
};

/// Cuts out all tetrahedra at the vertices of `near`, in their order; there, of the kActive vertices only those of
/// `near` are active. The mesh stays as it is. The cost grows with the band, but for two bytes per tetrahedron and
/// vertex. Not collective. @pre the mesh is compact
Band cut_band(const TetMesh& mesh, const VertexAttributes& data, Surroundings near, int threads);
/// The same within `layers` edges of all kActive vertices of a rank's mesh; only these are active.
/// @pre the data begins with the log-metric
Band cut_band(DistMesh& dist, int layers, int threads = 1);

/// Puts an adapted band in the place of the one that was cut. `old2new` follows the band's vertices that were frozen
/// (adapt_local). Vertices of the rest and frozen ones keep their global ids, all others get kNoGlobal. The result is
/// compact; numbers that are free are filled from the end, and dist.sharing follows. Not collective.
/// @pre dist is as it was when the band was cut; the band is compact.
void put_back(DistMesh& dist, const Band& band, const IdVector<VertId, VertId>& old2new, int threads = 1);
void put_back(TetMesh& mesh, VertexAttributes& data, const Band& band, const IdVector<VertId, VertId>& old2new,
              int threads);

}  // namespace skein
