/// \file
/// Skein in memory: a distributed mesh and what it shall be like go in as arrays, the adapted mesh comes out.
///
///     #include <skein/skein.hpp>
///
///     skein::SlicedMesh mesh;                               // this rank's slice of the vertices and tetrahedra
///     mesh.coords = ..., mesh.tets = ..., mesh.triangles = ...;
///     skein::Options options;
///     options.complexity = 50000;                           // about ten times as many tetrahedra
///     auto fine = skein::adapt(comm, std::move(mesh), skein::Target::field(mach), {5, std::move(state)}, options);
///     use(fine.mesh.coords, fine.mesh.tets, fine.fields.values, fine.report.quality_min);
///
/// Rules that hold for all of it:
///   - MPI is the caller's: initialised before the first call and finalised after the last. Skein works on duplicates
///     of the communicator, which it frees before it returns. Any communicator will do, not only MPI_COMM_WORLD.
///   - adapt() is collective over the communicator. Ranks without vertices or tetrahedra are fine, and take part.
///   - All numbers count from 0. Lengths are in the unit of the coordinates.
///   - Arrays are ordinary vectors. Arguments are taken by value: std::move() what is not needed any more, and Skein
///     frees it as soon as it has read it. Results belong to the caller.
///   - Errors are exceptions of type skein::Error, the same on all ranks of the communicator; ranks outside of it
///     notice nothing. Nothing is printed, and the process is never ended.
#pragma once
#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "skein/error.hpp"
#include "skein/export.h"
#include "skein/version.h"

namespace skein {

/// The version of the library that is linked, such as "0.1.0"; SKEIN_VERSION is that of the headers.
SKEIN_EXPORT const char* version() noexcept;

/// \name The mesh
/// \{

/// A distributed mesh in consecutive slices. Rank 0 has the first vertices, rank 1 the next, and so on; slices may
/// differ in size and be empty. The number of a vertex is its place in this order, over all ranks. Tetrahedra,
/// triangles and edges are in slices of their own, and name vertices by these numbers: any rank may have any of them.
struct SlicedMesh {
  std::vector<std::array<double, 3>> coords;      ///< one per vertex of the slice
  std::vector<std::array<std::int64_t, 4>> tets;  ///< vertex numbers; those of negative volume are turned
  std::vector<std::array<std::int64_t, 3>>
      triangles;                                   ///< on the boundary and between regions, each on one rank. A face
                                                   ///< of the hull that no triangle covers gets a reference of its own
  std::vector<std::array<std::int64_t, 2>> edges;  ///< ridges, and other edges with a reference; may be empty

  std::vector<std::int32_t> vert_refs;      ///< reference of each vertex; empty: all 0. So are the next three
  std::vector<std::int32_t> tet_refs;       ///< region of each tetrahedron
  std::vector<std::int32_t> triangle_refs;  ///< patch of each triangle: kept by adapting, and so is its border
  std::vector<std::int32_t> edge_refs;      ///< reference of each edge

  std::vector<std::int64_t> corners;             ///< vertex numbers; they never move and never go
  std::vector<std::int64_t> required_verts;      ///< vertex numbers; the same
  std::vector<std::int64_t> ridges;              ///< edge numbers: place in the slices of edges over all ranks
  std::vector<std::int64_t> required_edges;      ///< edge numbers; kept as they are
  std::vector<std::int64_t> required_triangles;  ///< triangle numbers; kept as they are
  std::vector<std::int64_t> required_tets;       ///< tetrahedron numbers: place in the slices; kept as they are
};

/// A distributed mesh in parts, as solvers have it: every rank has some tetrahedra and their vertices under local
/// numbers. A vertex at the border of parts is on several ranks, which know it by the same global number.
struct PartitionedMesh {
  std::vector<std::array<double, 3>> coords;  ///< one per local vertex; all copies of a vertex have the same bits
  std::vector<std::int64_t> local2global;     ///< one per local vertex: any numbers >= 0, with gaps or not, on a rank
                                              ///< each once. A result has 0, 1, 2 ... over all ranks
  std::vector<std::array<std::int32_t, 4>> tets;       ///< local vertex numbers; each tetrahedron on one rank
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< as in SlicedMesh; one between two parts may be on both
                                                       ///< ranks when it is given, and is on one in a result
  std::vector<std::array<std::int32_t, 2>> edges;      ///< as in SlicedMesh; the same holds for edges

  std::vector<std::int32_t> vert_refs;      ///< as in SlicedMesh; of copies that differ the lowest rank's counts
  std::vector<std::int32_t> tet_refs;       ///< as in SlicedMesh
  std::vector<std::int32_t> triangle_refs;  ///< as in SlicedMesh
  std::vector<std::int32_t> edge_refs;      ///< as in SlicedMesh

  std::vector<std::int32_t> corners;             ///< local vertex numbers; one copy is enough
  std::vector<std::int32_t> required_verts;      ///< local vertex numbers; one copy is enough
  std::vector<std::int32_t> ridges;              ///< local edge numbers: places in `edges` of this rank
  std::vector<std::int32_t> required_edges;      ///< local edge numbers
  std::vector<std::int32_t> required_triangles;  ///< local triangle numbers
  std::vector<std::int32_t> required_tets;       ///< local tetrahedron numbers
};
/// \}

/// \name What the mesh shall be like
/// \{

/// What the new mesh is adapted to: numbers at the vertices of the old one, in their order. In a PartitionedMesh all
/// copies of a vertex have numbers, and the lowest rank's count.
struct Target {
  /// What the numbers are.
  enum class Kind {
    kMetric,    ///< 6 per vertex: a symmetric positive tensor M as m11 m12 m22 m13 m23 m33; edge e has length
                ///< sqrt(e' M e), ideal 1; unit 1/length^2
    kSize,      ///< 1 per vertex: the wanted length of edges, > 0
    kField,     ///< 1 per vertex: a solution; its second derivatives make the metric. Needs Options::complexity,
                ///< elements or vertices
    kOwnSizes,  ///< none: the mesh keeps the sizes and directions of its own edges, and is improved
  };
  Kind kind = Kind::kSize;     ///< what the numbers are
  std::vector<double> values;  ///< vertex after vertex

  /// Tensors, 6 numbers per vertex.
  static Target metric(std::vector<double> values) { return {Kind::kMetric, std::move(values)}; }
  /// Lengths, 1 number per vertex.
  static Target size(std::vector<double> values) { return {Kind::kSize, std::move(values)}; }
  /// A solution, 1 number per vertex.
  static Target field(std::vector<double> values) { return {Kind::kField, std::move(values)}; }
  /// The mesh's own sizes.
  static Target own_sizes() { return {Kind::kOwnSizes, {}}; }
};

/// Numbers that are carried from the old vertices to the new ones: linear in each old tetrahedron, so that a linear
/// field stays what it is (to rounding), and at old vertices every field. `width` and the meaning of the numbers are
/// the caller's, but `width` is the same on all ranks.
struct Fields {
  int width = 0;               ///< numbers per vertex; 0: nothing is carried
  std::vector<double> values;  ///< vertex after vertex; copies in a PartitionedMesh as for Target
};

/// What a phase of adapt() tells when it begins and when it ends.
struct Progress {
  std::string phase;      ///< such as "round 1: adapt"
  bool finished = false;  ///< false: the phase begins; true: it has ended
  double seconds = 0;     ///< since adapt() was called
  std::int64_t tets = 0;  ///< tetrahedra of all ranks at the end of the phase (0 when it begins)
};

/// Options of adapt(): those of the command line (docs/cli.md) with the same defaults. The same on all ranks, but for
/// `progress`.
struct Options {
  /// How points are created.
  enum class Points {
    kEdges,     ///< along long edges
    kCentroids  ///< at centroids of large tetrahedra, with exclusion zones
  };
  /// How vertices are moved.
  enum class Smoothing {
    kQuality,  ///< to the best quality of their elements
    kSprings   ///< by springs along their edges
  };

  double complexity = 0;  ///< scale the metric to this complexity, about a tenth of the tetrahedra; 0: as it is
  double elements = 0;    ///< in place of `complexity`: scale the metric to so many tetrahedra; 0: not given
  double vertices = 0;    ///< the same by the number of vertices
  double h_min = 0;       ///< smallest edge length; 0: no bound
  double h_max = std::numeric_limits<double>::infinity();  ///< largest edge length
  double aspect_max = 0;            ///< largest over smallest edge length at a vertex, at least 1; 0: no bound
  double norm = 2;                  ///< with Target::field: the L^p norm of the error to minimise, p >= 1 or infinity
  std::optional<double> gradation;  ///< sizes grow at most by this factor per edge, > 1; 0: no bound. Not set: 1.3 with
                                    ///< Target::size, no bound otherwise
  double ridge_angle = 45;          ///< surface edges folded by more than this are kept as ridges; degrees
  double max_elements = 0;          ///< refuse a metric that asks for more; 0: for more than there is memory for
  std::vector<std::int32_t> freeze_patches;  ///< references of triangles that stay as they are
  std::vector<std::int32_t> freeze_regions;  ///< references of tetrahedra that stay as they are
  bool surface = true;                       ///< boundary triangles may change; false: they are kept as they are

  /// The method: the passes with all numbers that steer them. At most one of the next three is given, with none it is
  /// the preset "default".
  std::string preset;       ///< name of a method: "default", "chapter" or "quick" (docs/cli.md)
  std::string config;       ///< a method as a text, in the form that `skein adapt --dump-config` prints (TOML); what it
                            ///< does not name is as in its `preset`
  std::string config_file;  ///< the same in a file, which rank 0 reads
  std::optional<Points> points;        ///< how points are created; not set: as the method has it
  std::optional<Smoothing> smoothing;  ///< how vertices are moved; not set: as the method has it

  int rounds = 3;              ///< rounds over the ranks, each with other borders between the parts
  int threads = 1;             ///< threads in each rank; they do not call MPI
  bool return_metric = false;  ///< Adapted::metric is wanted

  /// Called on every rank, in the thread that called adapt(), when a phase begins and when it has ended. Returns true
  /// to go on. When it returns false on any rank, all ranks end with ErrorCode::kCancelled at the end of the phase. It
  /// must not call collectives of MPI that the ranks do not all come to; ranks without a function may be among them.
  std::function<bool(const Progress&)> progress;
};
/// \}

/// \name What comes out
/// \{

/// A phase of the run: its name and the wall time of the slowest rank.
struct PhaseTime {
  std::string name;    ///< as in Progress
  double seconds = 0;  ///< wall time
};

/// What adapt() did; the same on all ranks.
struct Report {
  std::int64_t vertices_in = 0;    ///< of the mesh given
  std::int64_t tets_in = 0;        ///< of the mesh given
  std::int64_t vertices = 0;       ///< of the new mesh; shared ones once
  std::int64_t tets = 0;           ///< of the new mesh
  double complexity = 0;           ///< of the metric on the new mesh
  double unit_edges = 0;           ///< per cent of the edges with a metric length in [1/sqrt 2, sqrt 2]
  double quality_min = 0;          ///< metric mean ratio of the worst tetrahedron: 1 is perfect, 0 is flat
  double quality_mean = 0;         ///< of all tetrahedra
  double seconds = 0;              ///< wall time of adapt() on the slowest rank
  std::vector<PhaseTime> phases;   ///< in their order
  std::vector<std::string> notes;  ///< what was found in the input, such as faces without a triangle; may be empty
};

/// The result of adapt(): the new mesh in the convention of the old one.
template <class Mesh>
struct Adapted {
  Mesh mesh;                   ///< the new mesh, about equal numbers of tetrahedra on all ranks, positively oriented
  Fields fields;               ///< the carried fields at its vertices
  std::vector<double> metric;  ///< with Options::return_metric: the metric at its vertices, 6 numbers each
  Report report;               ///< what was done
};
/// \}

/// \name The function
/// \{

/// Adapts the mesh, so that its edges have length 1 in the metric of `target`. Collective over `comm`.
///
/// `target` and `fields` have their numbers at the vertices of this rank, in their order; `fields` may be left out.
/// The same arrays on the same number of ranks give the same result, bit by bit, and the program `skein adapt` gives
/// the same mesh for a file of this mesh.
///
/// Throws Error on all ranks of `comm`: kInvalidMesh when the mesh is not a valid one (the text names tetrahedra or
/// vertices by their numbers, and where they are), kInput when a metric is not positive definite, a size is not
/// greater than 0, counts do not fit, or the method's numbers make no sense (the text names line and key), kUsage when
/// an option makes no sense, kCancelled when `progress` has asked for it, kInternal when memory is short. After an
/// error, what was moved in is gone, and `comm` is as it was.
[[nodiscard]] SKEIN_EXPORT Adapted<SlicedMesh> adapt(MPI_Comm comm, SlicedMesh mesh, Target target, Fields fields = {},
                                                     const Options& options = {});
/// The same for a mesh in parts. Throws kInvalidMesh, too, when copies of a vertex have different coordinates.
[[nodiscard]] SKEIN_EXPORT Adapted<PartitionedMesh> adapt(MPI_Comm comm, PartitionedMesh mesh, Target target,
                                                          Fields fields = {}, const Options& options = {});
/// \}

}  // namespace skein
