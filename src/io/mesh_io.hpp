// Reading and writing meshes and solutions; the format follows from the ending of the path.
#pragma once
#include <string>

#include "comm/comm.hpp"
#include "io/mesh_slice.hpp"

namespace skein {

/// Collective. Reads .mesh (Medit text) or .meshb (GMF binary, versions 1 to 4; either byte order), each rank its even
/// slices. Throws Error(kInput) on all ranks, naming file and line (text) or byte and entity (binary).
MeshSlice read_mesh(const Comm& comm, const std::string& path);
/// Collective. Writes .mesh, .meshb, .vtu or .pvtu (format by the ending); the slices may be of any size, in rank order
/// (first must be the sum of the lower ranks' sizes). Written under a temporary name, then renamed.
void write_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields = nullptr);
/// Collective. .sol or .solb.
FieldSlice read_fields(const Comm& comm, const std::string& path);
/// Collective.
void write_fields(const Comm& comm, const std::string& path, const FieldSlice& fields);

}  // namespace skein
