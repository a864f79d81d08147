// Transfer: the fields of the old mesh at points of the new one, over all ranks.
#pragma once
#include <cstdint>
#include <span>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "solution/transfer_locator.hpp"

namespace skein {

/// Counts of a transfer, over all ranks.
struct TransferReport {
  std::int64_t points = 0;   ///< asked for
  std::int64_t remote = 0;   ///< of these: answered by another rank
  std::int64_t outside = 0;  ///< of these: not in the old mesh (beyond rounding), so taken from its nearest point
  double farthest = 0;       ///< largest distance of any point to the old mesh; length
};

/// The old mesh with fields at its vertices. Each rank keeps its part (coordinates, tetrahedra, fields). All ranks have
/// a few bounding boxes of every part, which tell which ranks to ask for a point.
class Background {
 public:
  /// Collective. Copies what it needs of `dist`; `fields` are its fields, equal on all copies of a vertex. `comm` must
  /// outlive it. Fast when tetrahedra are in Hilbert order, as distribute() makes it. Throws Error(kInternal) on all
  /// ranks when the fields do not fit the mesh, or there is no tetrahedron. @pre dist is compact and reconciled.
  Background(const Comm& comm, const DistMesh& dist, VertFields fields);

  /// Collective. The fields at these points (any number, also none): interpolated linearly in the tetrahedron that
  /// contains the point, on whichever rank it is. Outside of the mesh, the fields at the nearest point of the mesh.
  /// Exact to rounding for linear fields, exact for constant ones and at old vertices. All components alike, those of
  /// tensors, too.
  [[nodiscard]] VertFields at(std::span<const Vec3> points, int threads = 1, TransferReport* report = nullptr) const;

  /// Collective. at() the vertices of `dist`, the same bits on all copies.
  [[nodiscard]] VertFields at_vertices(const DistMesh& dist, int threads = 1, TransferReport* report = nullptr) const;

 private:
  struct Asking;
  /// What a rank answers for a point that none of its tetrahedra holds.
  enum class Beyond : std::uint8_t { kNothing, kNearest };
  void ask_ranks_inside(Asking& a) const;
  void ask_nearest(Asking& a) const;
  void ask(Asking& a, const std::vector<Rank>& dest, const std::vector<std::uint32_t>& who, Beyond beyond) const;
  [[nodiscard]] TransferReport make_report(const Asking& a, std::int64_t away) const;
  void evaluate(const Place& place, double* out) const noexcept;

  const Comm* comm_;
  TetLocator locator_;
  VertFields fields_;
  BoxTree boxes_;               ///< of all ranks
  std::vector<Rank> box2rank_;  ///< ascending
};

/// A column of tensors as fields (Medit order), and back.
VertFields fields_of(const IdVector<VertId, SymTensor>& tensors);
IdVector<VertId, SymTensor> tensors_of(const VertFields& fields);

}  // namespace skein
