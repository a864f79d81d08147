// The steps of distribute(); private to it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "dist/blocks.hpp"
#include "dist/distribute.hpp"
#include "dist/rendezvous.hpp"

namespace skein::distributing {

/// The file's slices, and what other ranks have told this one about its entities.
struct FileSource {
  const Comm& comm;
  const MeshSlice& file;
  const FieldSlice* fields;
  const DistributeOptions& options;
  Blocks vert_blocks;
  std::vector<VertClass> vert_class;            ///< kSurface: on a triangle; kRidge: on an edge; kCorner; kRequired
  std::vector<FeatureClass> edge_class;         ///< by local edge: kRidgeEdge, kRequiredEdge
  std::vector<std::uint8_t> triangle_required;  ///< by local triangle
  std::vector<TetClass> tet_class;              ///< by local tetrahedron
  std::vector<std::uint8_t> tet_dropped;        ///< by local tetrahedron; empty: none
};

/// The distributed mesh, as far as the steps have built it.
struct Growing {
  DistMesh dist;
  GidMap gid2vert{0};
  IdVector<TetId, std::int64_t> tet_number;  ///< in the file, from 0
  IdVector<VertId, std::uint8_t> many;       ///< 1 when other ranks have this vertex, too
  int bare_hull_patch = -1;                  ///< of hull faces without triangle; -1: there are none
  std::vector<FaceId> speakers;              ///< each tagged face once over all ranks, also where it has two sides
};

/// A fault of the file.
struct Offence {
  std::int64_t number = -1;  ///< entity, from 0
  std::int64_t other = -1;   ///< a second entity of the same kind, or -1
  std::array<GlobalId, 4> verts{kNoGlobal, kNoGlobal, kNoGlobal, kNoGlobal};
};
/// Collective. If any rank has offences: throws Error(kInvalidMesh) on all ranks, "path: what: numbers (n in all), the
/// first at ...; advice". Returns otherwise.
void refuse(const FileSource& src, std::vector<Offence> offences, const std::string& what, const std::string& advice);

// All collective, in this order.
FileSource open_source(const Comm& comm, const MeshSlice& file, const FieldSlice* fields,
                       const DistributeOptions& options);
std::int64_t count_double_edges(const FileSource& src);
Growing place_tets(const FileSource& src, DistributeReport& report);
/// False when there are tetrahedra given again: they are marked in src.tet_dropped now, and place_tets() must follow.
[[nodiscard]] bool match_and_tag_faces(FileSource& src, Growing& g, DistributeReport& report);
void check_hull(const FileSource& src, const Growing& g, DistributeReport& report);
void find_features(const FileSource& src, Growing& g, DistributeReport& report);
/// Collective. The part of find_features that looks at the tagged faces of each feature edge: kThinEdge, kContactEdge,
/// and at vertices kThin, kContact, and kCorner where the faces of two feature edges differ.
void classify_features(const Comm& comm, Growing& g);

}  // namespace skein::distributing
