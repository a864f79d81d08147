// Elements, areas and volumes by patch and region; the worst elements and where they are.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "report/json.hpp"
#include "report/statistics.hpp"

namespace skein {

/// A patch or a region.
struct CensusRow {
  std::int32_t ref = 0;    ///< of its triangles or tetrahedra
  std::int64_t count = 0;  ///< triangles or tetrahedra
  double size = 0;         ///< area or volume
};
struct Census {
  std::vector<CensusRow> patches, regions;  ///< ascending by reference
};
/// Collective. The same on every rank, sums to rounding. A triangle between two tetrahedra counts once.
Census census(const Comm& comm, const DistMesh& dist);

/// `patches` and `regions` with what there was before and is after, for the report.
Json to_json(const Census& before, const Census& after);
/// Lines for people: counts before and after, and how much the area or volume has changed. Of very many patches only
/// the first.
std::vector<std::string> to_lines(const Census& before, const Census& after);
/// What there is, in one line.
std::string to_line(const Census& now);

/// An element, where it is, and what its vertices are bound to.
struct WorstTet {
  double quality = 0;                         ///< metric mean ratio; of Measure::kInSpace in the identity
  Vec3 at;                                    ///< its centroid
  std::array<GlobalId, 4> verts{};            ///< ascending
  std::int32_t region = 0;                    ///< reference
  std::int32_t patch = 0, faces = 0;          ///< how many faces are on patches, and the reference of the first
  double min_dihedral = 0, max_dihedral = 0;  ///< degrees
  std::array<std::int32_t, 4> bound{};        ///< vertices that stay, on ridges, on the surface, inside
};
/// Collective. The n elements of least quality, worst first; the same on every rank.
std::vector<WorstTet> worst_tets(const Comm& comm, const DistMesh& dist, std::size_t n, Measure measure);
/// "quality 0.123 at (x, y, z), region 1, ..."
std::string to_line(const WorstTet& t);
Json to_json(const WorstTet& t);

}  // namespace skein
