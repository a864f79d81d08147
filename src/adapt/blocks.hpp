// Blocks: a rank's mesh cut into one part per thread, and joined again.
#pragma once
#include <cstdint>
#include <vector>

#include "kernel/part.hpp"
#include "mesh/free_slots.hpp"

namespace skein {

/// Which thread works on each tetrahedron.
using BlockLabels = IdVector<TetId, std::int32_t>;

/// What cutting each face (FaceId) costs: its area in the metric, i.e. about how many faces of the final mesh it stands
/// for; 1 to 1000. @pre the mesh has the column metric
std::vector<std::int32_t> face_costs(const TetMesh& mesh, int threads = 1);

/// The block of each tetrahedron: compact blocks of equal predicted work with small interfaces in the final mesh, from
/// the multilevel partitioner. Needs MPI, but no other rank. @pre no free slots; the mesh has log_metric and metric.
BlockLabels cut_blocks(const TetMesh& mesh, int blocks, const Method::Threads& method = {});

/// True for each vertex that has tetrahedra of several blocks.
IdVector<VertId, char> between_blocks(const TetMesh& mesh, const BlockLabels& label);

/// A block: a part, and the numbers of its vertices in the mesh that it was cut from.
struct Block {
  Part part;
  /// Per vertex of the part as it was cut: its number in the whole mesh; for a new one on the interface between blocks
  /// a hashed id (refine_interface). Empty after seal_block.
  IdVector<VertId, GlobalId> id;
  std::vector<VertId> common;       ///< the part's vertices that other blocks have, too (frozen)
  std::vector<GlobalId> common_id;  ///< ... and their ids, from seal_block on
  std::vector<VertId>
      frozen;  ///< the part's vertices that were frozen before the cut, ascending (shared with other ranks)
  std::vector<VertId> frozen_of;  ///< ... and their number in the whole mesh
  /// From seal_block on: where the last tetrahedra must move to fill the free slots. Part's lists of free slots are
  /// then ascending.
  Moved<TetId> tets;
};

/// Cuts block b out of the mesh. Faces to other blocks have no neighbour; their vertices are frozen. Thread-safe.
Block cut_block(const TetMesh& mesh, const BlockLabels& label, const IdVector<VertId, char>& between, int b);

/// Applies a renumbering of the part's vertices, old -> new. Vertices that other blocks have, too, must not be dropped.
/// Thread-safe.
void follow(Block& block, const IdVector<VertId, VertId>& old2new);

/// Refines the interface to other blocks where its edges are too long (refine_interface). False when that fails; the
/// block is then of no use. Thread-safe.
bool refine_block_interface(Block& block, double times = 1);

/// Applies the renumbering of the part's vertices by adapt_part, and finds the free slots. Where these are many it
/// removes them. Thread-safe.
void seal_block(Block& block, const IdVector<VertId, VertId>& old2new);

/// What merge_blocks gives: the whole mesh again.
struct Merged {
  TetMesh mesh;
  std::vector<VertId> between;       ///< the vertices that several blocks had, ascending
  IdVector<VertId, VertId> old2new;  ///< for vertices of the mesh before the cut that were frozen; kNoVert for others
};
/// Joins the blocks, with as many threads as there are blocks, and empties them. Copies of a vertex become one, and
/// faces between blocks become neighbours. The first block stays in its arrays; the others fill its free slots and then
/// follow it. So reserve room for all blocks in the first one. @pre sealed; the interfaces are as they were cut.
/// `old_verts`: number of vertices before the cut.
Merged merge_blocks(std::vector<Block>& blocks, std::size_t old_verts);

}  // namespace skein
