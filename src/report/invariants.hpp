// What an adaptation must not change, as sums over all ranks: made before and after, and compared at the end.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "dist/reference.hpp"
#include "report/json.hpp"

namespace skein {

/// What the end check lets pass.
struct EndCheckLimits {
  /// Relative difference of what must be the same to rounding. Sums over millions of entities stay far below.
  double rounding = 1e-9;
  /// Relative difference of areas, volumes and lengths where the surface or line is curved: a coarser chord is shorter.
  double curved = 0.01;
};

/// Two neighbouring facets, or two edges of a line, that are turned by less than this (radians) are in one plane or on
/// one straight line. Coordinates of 15 digits stay below, such of 8 digits count as curved.
inline constexpr double kStraight = 1e-9;

/// A volume, an area or a length.
struct Extent {
  std::int64_t key = 0;  ///< reference; of a line: see line_key()
  double value = 0;
  double curved = 0;  ///< nonzero where a new facet or edge may leave what it replaces
  double smooth = 0;  ///< what is added where the curved surface is followed instead of the facets (add_smooth)
};
constexpr std::int64_t line_key(const FeatureEdge& e) noexcept {
  return std::int64_t{e.ref} * 256 + static_cast<int>(e.edge_class);
}

/// A set of faces and edges: vertices - edges + faces, and of how many pieces it is made.
struct Shape {
  std::int64_t euler = 0, components = 0;
  friend bool operator==(const Shape&, const Shape&) = default;
};

/// A set of entities that must stay: how many, and a sum of hashes of their coordinates (bit by bit) and references.
struct Roll {
  std::uint64_t count = 0, hash = 0;
  friend bool operator==(const Roll&, const Roll&) = default;
};

/// Sums over all ranks, the same on every rank. Some numbers per reference; nothing of the mesh itself.
struct Invariants {
  std::vector<Extent> regions, patches, lines;  ///< ascending by key
  std::vector<Shape> shapes;                    ///< of each patch, of the hull, of all feature edges
  Roll corners, required_verts, required_edges, required_triangles, required_tets;
  double hull_volume = 0;  ///< enclosed by the hull's faces
  double size = 0;         ///< diagonal of the bounding box times area of all patches: scale of volume errors
  std::int64_t nonpositive_tets = 0;  ///< by the exact predicate
};

/// Collective. @pre dist is compact, and all shared vertices have a global id.
Invariants invariants(const Comm& comm, const DistMesh& dist);

/// What of areas, lengths and volumes changes when the facets follow the curved surface; to invariants of the mesh that
/// the surface was made of. Not collective.
void add_smooth(Invariants& before, const TetMesh& mesh, const BoundarySurface& boundary,
                const ReferenceSurface& surface);

/// The same where the surface was made of another mesh: what its curved boundary has, and `before` not yet.
void expect_smooth(Invariants& before, const Invariants& of_original);

struct EndCheckReport {
  std::int64_t compared = 0;
  double largest_exact = 0;   ///< relative difference of what must be the same to rounding
  double largest_curved = 0;  ///< relative difference where the boundary is curved
  std::vector<std::string> faults;
  [[nodiscard]] bool passed() const noexcept { return faults.empty(); }
};

/// What differs by more than the limits. Not collective: the same answer for the same sums.
EndCheckReport compare(const Invariants& before, const Invariants& after, const EndCheckLimits& limits = {});

/// All faults in one line.
std::string to_line(const EndCheckReport& report);
Json to_json(const EndCheckReport& report);

}  // namespace skein
