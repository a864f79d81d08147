// Reading and writing meshes and solutions; the format follows from the ending of the path.
#pragma once
#include <string>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// Version of a GMF binary file (.meshb, .solb). Old programs read only low ones (docs/formats.md).
enum class GmfVersion {
  kLowest = 0,  ///< the lowest of the next three that holds the file
  k2 = 2,       ///< 32-bit numbers and positions: files of less than 2 GiB
  k3 = 3,       ///< 64-bit positions
  k4 = 4,       ///< 64-bit numbers
};

/// Collective. Reads .mesh (Medit text) or .meshb (GMF binary, versions 1 to 4; either byte order), each rank its even
/// slices. A file without tetrahedra is fine (a surface). Throws Error(kInput) on all ranks, naming file and line
/// (text) or byte (binary) and entity.
MeshSlice read_mesh(const Comm& comm, const std::string& path);
/// Collective. Writes .mesh, .meshb, .vtu or .pvtu (format by the ending); the slices may be of any size, in rank order
/// (first must be the sum of the lower ranks' sizes). Written under a temporary name, then renamed. The bytes of .mesh,
/// .meshb and .vtu depend on the mesh only, not on the ranks; .pvtu writes one piece <stem>_<rank>.vtu per rank.
/// `version` is that of .meshb; Error(kOutput) on all ranks when the mesh does not fit it. `fields` at the
/// vertices and `on_tets`, scalars at the tetrahedra of the slice, go into .vtu and .pvtu only (.mesh and .meshb have
/// no place for them: write_fields).
void write_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields = nullptr,
                GmfVersion version = GmfVersion::kLowest, const FieldSlice* on_tets = nullptr);
/// Collective. .sol or .solb. Throws Error(kInput) on all ranks as read_mesh does; values that are not finite are
/// refused with vertex and field. Whether `total` fits the mesh is for the caller to check.
FieldSlice read_fields(const Comm& comm, const std::string& path);
/// Collective. .sol or .solb; slices and naming as for write_mesh.
void write_fields(const Comm& comm, const std::string& path, const FieldSlice& fields,
                  GmfVersion version = GmfVersion::kLowest);
/// Collective. Throws Error(kOutput) on all ranks when write_mesh or write_fields would refuse the path: ending
/// unknown, folder missing or not writable. For the start of a run, so that it does not fail at its end; leaves nothing
/// behind.
void require_output(const Comm& comm, const std::string& path);

}  // namespace skein
