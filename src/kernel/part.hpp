// Part: one worker's mesh with its metric, cached qualities and scratch memory. One part, no MPI, no threads.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/geometry.hpp"
#include "kernel/contact.hpp"
#include "kernel/method.hpp"
#include "mesh/tet_mesh.hpp"
#include "metric/mesh_metric.hpp"
#include "metric/spacing.hpp"

namespace skein {

/// Whether facets (tagged faces) may change.
enum class SurfaceChange : std::uint8_t { kAllowed, kNone };
/// Where the passes begin.
enum class Scope : std::uint8_t {
  kActive,  ///< at all kActive vertices
  kRetry    ///< at kRetry vertices only, and on to what changes, where active
};
/// How the quality of a tetrahedron is measured when its vertices have different metrics.
enum class QualityMeasure : std::uint8_t {
  kLargestMetric,  ///< in the metric of largest determinant (quality_cubed)
  kLeast           ///< the least over the metrics of nearly that determinant (least_quality_cubed)
};

/// How the passes are driven on one part.
struct KernelOptions {
  Method method;
  SurfaceChange surface = SurfaceChange::kAllowed;
  Scope scope = Scope::kActive;
  int least_turns = 0;        ///< of the main passes, even if little changes any more; 0: as the method has it
  bool lower_strain = false;  ///< strained edges are worked on one by one after the main passes
  /// The metric turns within the elements of the mesh that this part is of. Not set: as the part itself looks, which
  /// for a band round bad elements would say nothing.
  std::optional<bool> turning = {};

  [[nodiscard]] bool may_change_surface() const noexcept { return surface == SurfaceChange::kAllowed; }
  [[nodiscard]] bool only_retry() const noexcept { return scope == Scope::kRetry; }
};

/// The kinds of passes, as bits of Part::dirty. A pass looks only at what has changed since it looked last, so that a
/// converged mesh costs nothing but a scan of one byte per tetrahedron. Two bits stay: what was to be looked at from
/// the beginning or has changed since is improved, and beside what has changed vertices may become retry vertices.
enum Pass : std::uint8_t {
  kCollapsePass = 1,
  kInsertPass = 2,
  kSwapPass = 4,
  kSmoothPass = 8,
  kMainPasses = 15,
  kWorstPass = 16,
  kSumPass = 32,
  kImprovement = kWorstPass | kSumPass,
  kToImprove = 64,
  kHasChanged = 128,
  kFromTheStart = kMainPasses | kImprovement | kToImprove,
  kAnew = kFromTheStart | kHasChanged
};

/// Of an edge: it may be longer than split_above, shorter than collapse_below.
enum EdgeClass : std::uint8_t { kMayBeLong = 1, kMayBeShort = 2 };

/// The edges of a tetrahedron (bits of kEdgeVerts) of each class. The passes over lengths measure only these; who makes
/// or moves an edge keeps them right.
struct EdgeBits {
  std::uint8_t may_be_long = 0, may_be_short = 0;
  /// Adds the classes of edge e.
  constexpr void add(std::size_t e, std::uint8_t edge_class) noexcept {
    may_be_long = static_cast<std::uint8_t>(may_be_long | (edge_class & kMayBeLong) << e);
    may_be_short = static_cast<std::uint8_t>(may_be_short | (edge_class & kMayBeShort) >> 1 << e);
  }
  /// The classes of edge e.
  [[nodiscard]] constexpr std::uint8_t of(std::size_t e) const noexcept {
    return static_cast<std::uint8_t>((may_be_long >> e & 1) * kMayBeLong | (may_be_short >> e & 1) * kMayBeShort);
  }
  constexpr void keep(unsigned edges) noexcept {
    may_be_long = static_cast<std::uint8_t>(may_be_long & edges);
    may_be_short = static_cast<std::uint8_t>(may_be_short & edges);
  }
};
/// The edge between two local vertices, in kEdgeVerts.
inline constexpr std::array<std::array<std::uint8_t, 4>, 4> kEdgeOf{
    {{6, 0, 1, 2}, {0, 6, 3, 4}, {1, 3, 6, 5}, {2, 4, 5, 6}}};

/// What a part has done.
struct OperationCounts {
  std::int64_t insert = 0, collapse = 0, swap = 0, smooth = 0;
  /// Elements below Method::Improve::worst_below which no operator makes better, by what holds them: a vertex that must
  /// stay for now (interface), one on the boundary or a feature, or nothing but their surroundings.
  std::int64_t poor_at_interface = 0, poor_at_boundary = 0, poor_inside = 0;
  OperationCounts& operator+=(const OperationCounts& o) noexcept {
    insert += o.insert;
    collapse += o.collapse;
    swap += o.swap;
    smooth += o.smooth;
    poor_at_interface += o.poor_at_interface;
    poor_at_boundary += o.poor_at_boundary;
    poor_inside += o.poor_inside;
    return *this;
  }
};

/// A part of the mesh and all that a worker needs to change it. Vertices carry kActive where work is wanted, and
/// kFrozen on the interface to other parts.
struct Part {
  TetMesh mesh;                           ///< with log_metric and metric
  const SpacingField* spacing = nullptr;  ///< not owned; intersected into the metric of every new vertex
  KernelOptions options;
  OperationCounts counts;
  QualityMeasure quality_measure = QualityMeasure::kLargestMetric;
  double closest_new = Method{}.lengths.closest_new;  ///< of the pass at hand: no new point closer than this to another
  const Geometry* geometry = &default_geometry();     ///< not owned
  bool turning = false;                               ///< of the result: what options.turning shall be for bands of it

  // Kept by Cavity and the operators.
  IdVector<TetId, float> q3;                ///< quality_cubed of every tetrahedron
  IdVector<TetId, std::uint32_t> tet_mark;  ///< equal to the current stamp: in the set at hand
  IdVector<VertId, std::uint32_t> vert_mark;
  IdVector<VertId, std::uint8_t> edge_class;  ///< scratch: of the edge from the vertex at hand
  IdVector<TetId, std::uint8_t> refused;      ///< bits of kEdgeVerts: what this sweep has tried there in vain
  std::uint32_t tet_stamp = 0, vert_stamp = 0;
  std::vector<TetId> free_tets;
  std::vector<VertId> free_verts;
  IdVector<TetId, std::uint8_t> dirty;  ///< a bit per kind of pass (Pass): changed since that pass last looked at it
  IdVector<TetId, EdgeBits> edges;
  ContactFans contacts;
  bool has_thin = false;           ///< there are kThin vertices
  bool has_required_tets = false;  ///< there are kRequiredTet tetrahedra

  [[nodiscard]] std::int64_t live_verts() const noexcept {
    return std::ssize(mesh.coords.raw()) - std::ssize(free_verts);
  }
  [[nodiscard]] Vec3 x(VertId v) const noexcept { return mesh.coords[v]; }
  [[nodiscard]] double length(VertId a, VertId b) const noexcept {
    return edge_length(mesh.metric[a].m, mesh.metric[b].m, x(b) - x(a));
  }
  [[nodiscard]] double strain(VertId a, VertId b) const noexcept { return skein::strain(length(a, b)); }
  /// length(a, b) < l, mostly without a root.
  [[nodiscard]] bool is_shorter(VertId a, VertId b, double l) const noexcept {
    const Vec3 d = x(b) - x(a);
    const double qa = quad(mesh.metric[a].m, d), qb = quad(mesh.metric[b].m, d);
    return qa * qb < l * l * l * l && log_mean(std::sqrt(qa), std::sqrt(qb)) < l;
  }
  /// length(a, b) > l, mostly without a root.
  [[nodiscard]] bool is_longer(VertId a, VertId b, double l) const noexcept {
    const Vec3 d = x(b) - x(a);
    const double qa = quad(mesh.metric[a].m, d), qb = quad(mesh.metric[b].m, d);
    return qa + qb > 2 * l * l && log_mean(std::sqrt(qa), std::sqrt(qb)) > l;
  }
  /// EdgeClass bits of the edge from a to b, by bounds on its length that need no root: with la, lb its
  /// lengths in the metrics of its ends, the logarithmic mean lies between sqrt(la lb) and sqrt((la^2 + lb^2)/2).
  [[nodiscard]] std::uint8_t classify(VertId a, VertId b) const noexcept {
    const Vec3 d = x(b) - x(a);
    const double qa = quad(mesh.metric[a].m, d), qb = quad(mesh.metric[b].m, d);
    const double low2 = options.method.lengths.collapse_below * options.method.lengths.collapse_below;
    const bool is_long = qa + qb > 2 * options.method.lengths.split_above * options.method.lengths.split_above,
               is_short = qa * qb < low2 * low2;
    return static_cast<std::uint8_t>((is_long ? kMayBeLong : 0) | (is_short ? kMayBeShort : 0));
  }
  [[nodiscard]] EdgeBits classify_edges(TetId t) const noexcept {
    EdgeBits bits;
    const auto& v = mesh.tet2vert[t];
    for (std::size_t e = 0; e < 6; ++e) {
      bits.add(e, classify(v[kEdgeVerts[e][0]], v[kEdgeVerts[e][1]]));
    }
    return bits;
  }
  /// Q^3 of (a, b, c, d), as `quality_measure` wants it.
  [[nodiscard]] double quality_cubed(VertId a, VertId b, VertId c, VertId d) const noexcept {
    const auto& y = mesh.coords;
    const auto& m = mesh.metric;
    if (quality_measure == QualityMeasure::kLeast)
      return least_quality_cubed(y[a], y[b], y[c], y[d], m[a], m[b], m[c], m[d]);
    return skein::quality_cubed(y[a], y[b], y[c], y[d], m[a], m[b], m[c], m[d]);
  }
  /// A vertex of t has one of these flags.
  [[nodiscard]] bool has_any(TetId t, VertClass flags) const noexcept { return has_any(mesh.vert_class, t, flags); }
  [[nodiscard]] bool has_any(TetId t, VertState flags) const noexcept { return has_any(mesh.vert_state, t, flags); }
  /// t must stay as it is. Asks the mesh only where there are such tetrahedra.
  [[nodiscard]] bool must_stay(TetId t) const noexcept { return has_required_tets && mesh.has(t, kRequiredTet); }
  [[nodiscard]] bool active(TetId t) const noexcept { return has_any(t, kActive); }

 private:
  template <FlagSet Flags>
  [[nodiscard]] bool has_any(const IdVector<VertId, Flags>& of, TetId t, Flags flags) const noexcept {
    const auto& v = mesh.tet2vert[t];
    return any((of[v[0]] | of[v[1]] | of[v[2]] | of[v[3]]) & flags);
  }
};

/// Sizes the caches to the mesh and computes all qualities. @pre mesh has adjacency, log_metric and metric.
void prepare(Part& part);
/// Vertices that a unit mesh for the metric would have. @pre mesh has metric
std::int64_t expected_points(const TetMesh& mesh);
/// Room for about `points` vertices in the end, so that the arrays need not be copied while they grow.
void reserve(Part& part, std::size_t points);
/// Renumbers the part along the Hilbert curve, without free slots, so that what is near in space is near in memory.
/// Returns old vertex -> new vertex (kNoVert for free ones).
IdVector<VertId, VertId> compact(Part& part);
/// quality_cubed of a live tetrahedron, computed afresh.
double quality_cubed(const Part& part, TetId t) noexcept;
/// A vertex slot (recycled or new) with this position, log-metric and flags, and kActive; not yet in any tetrahedron.
/// The spacing field is intersected in. There is nothing in its other columns.
VertId new_vertex(Part& part, Vec3 x, const SymTensor& log_m, VertClass vert_class, VertState state = {});
/// Gives a vertex slot back. @pre no live tetrahedron has it.
void drop_vertex(Part& part, VertId v);

/// Finds what prepare() finds once: contacts, thin edges and required tetrahedra.
void find_special_features(Part& part);

/// Calls visit(edge, a, b, la, lb) for the edges in the mask (bits of kEdgeVerts), with their lengths in the metrics of
/// their ends.
template <class Visit>
void measure(const Part& p, const std::array<VertId, 4>& v, unsigned mask, Visit&& visit) {
  for (; mask != 0; mask &= mask - 1) {
    const auto e = static_cast<std::size_t>(std::countr_zero(mask));
    const VertId a = v[kEdgeVerts[e][0]], b = v[kEdgeVerts[e][1]];
    const Vec3 d = p.x(b) - p.x(a);
    visit(e, a, b, std::sqrt(quad(p.mesh.metric[a].m, d)), std::sqrt(quad(p.mesh.metric[b].m, d)));
  }
}

/// Calls visit(t) for the tetrahedra below `end` that have one of these bits (Pass) of `dirty` when their turn comes,
/// also for what is added meanwhile. Eight at a time where there are none.
template <class Visit>
void for_each_dirty(const Part& p, unsigned bits, std::size_t end, Visit&& visit) {
  constexpr std::size_t kAtOnce = sizeof(std::uint64_t);
  const std::uint64_t mask = bits * std::uint64_t{0x0101010101010101};
  for (std::size_t i = 0, n = 0; i < std::min(end, p.dirty.size()); i += n) {
    n = std::min(std::min(end, p.dirty.size()) - i, kAtOnce);
    std::uint64_t eight = 0;
    std::memcpy(&eight, p.dirty.data() + i, n);
    if ((eight & mask) == 0) continue;
    for (const TetId t : IdRange<TetId>(i, i + n)) {
      if ((p.dirty[t] & bits) != 0) visit(t);
    }
  }
}

/// Position of vertex v in its tetrahedron. @pre it is there.
constexpr std::size_t local_index(const std::array<VertId, 4>& tv, VertId v) noexcept {
  return std::size_t{tv[1] == v} + 2 * std::size_t{tv[2] == v} + 3 * std::size_t{tv[3] == v};
}
constexpr bool has_vertex(const std::array<VertId, 4>& tv, VertId v) noexcept {
  return tv[0] == v || tv[1] == v || tv[2] == v || tv[3] == v;
}

}  // namespace skein
