// The columns of vertices as bytes, to be sent to another rank.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"
#include "mesh/tet_mesh.hpp"

namespace skein {

/// Which columns there are on any rank, and where a vertex's entries lie in what is sent for it.
struct ColumnLayout {
  std::array<std::int64_t, kVertColumnCount> width{};  ///< numbers per vertex; 0: not there
  std::array<std::size_t, kVertColumnCount> at{};
  std::size_t bytes = 0;  ///< per vertex
};

/// Collective. Throws Error(kInternal) on all ranks when a rank with vertices has not the columns that others have.
ColumnLayout layout_of(const Comm& comm, const TetMesh& mesh);

/// The entries of these vertices, one vertex after another.
std::vector<std::byte> pack_columns(const TetMesh& mesh, const ColumnLayout& layout, const std::vector<VertId>& verts);

/// Puts entries that have been packed into the vertices `verts` of a mesh that gets room for `slots`; `fresh`: those of
/// them that were not here. Of others, flags are joined with those that come.
void unpack_columns(TetMesh& mesh, const ColumnLayout& layout, const std::vector<std::byte>& in,
                    const std::vector<VertId>& verts, const std::vector<VertId>& fresh, std::size_t slots);

}  // namespace skein
