// The functions of each format, for mesh_io.cpp. Paths and slices as in mesh_io.hpp; all functions are collective.
#pragma once
#include <string>

#include "comm/comm.hpp"
#include "io/mesh_io.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein::io {

// GMF binary (.meshb, .solb)
MeshSlice read_gmf_mesh(const Comm& comm, const std::string& path);
FieldSlice read_gmf_fields(const Comm& comm, const std::string& path);
/// Throws Error(kOutput) on all ranks when the file does not fit the version asked for.
void write_gmf_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh,
                    GmfVersion asked = GmfVersion::kLowest);
void write_gmf_fields(const Comm& comm, const std::string& path, const FieldSlice& fields,
                      GmfVersion asked = GmfVersion::kLowest);
/// The lowest version from 2 on for a file whose largest number is `largest` and which has `bytes` bytes as version 2.
int gmf_version_for(std::int64_t largest, std::int64_t bytes) noexcept;

// Medit text (.mesh, .sol)
MeshSlice read_medit_mesh(const Comm& comm, const std::string& path);
FieldSlice read_medit_fields(const Comm& comm, const std::string& path);
void write_medit_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh);
void write_medit_fields(const Comm& comm, const std::string& path, const FieldSlice& fields);

// VTK XML
/// One file for all ranks: tetrahedra, then triangles; cell array "ref"; point arrays from `fields`, cell arrays from
/// `on_tets` (nullptr: none).
void write_vtu(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields,
               const FieldSlice* on_tets);
/// <stem>_<rank>.vtu for each rank's cells with the vertices they need, and the index `path`.
void write_pvtu(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields,
                const FieldSlice* on_tets);
/// Text as it may stand inside a quoted XML attribute.
std::string xml_escaped(const std::string& s);
/// The XML attributes that describe field i: name, components and their names.
std::string vtk_field_attributes(const FieldSlice& fields, std::size_t i);

}  // namespace skein::io
