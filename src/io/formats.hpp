// The functions of each format, for mesh_io.cpp. Paths and slices as in mesh_io.hpp; all functions are collective.
#pragma once
#include <string>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein::io {

// GMF binary (.meshb, .solb)
MeshSlice read_gmf_mesh(const Comm& comm, const std::string& path);
FieldSlice read_gmf_fields(const Comm& comm, const std::string& path);
/// version 3 (32-bit numbers) or 4 (64-bit); 0 takes 3 unless a number needs 4.
void write_gmf_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh, int version = 0);
void write_gmf_fields(const Comm& comm, const std::string& path, const FieldSlice& fields, int version = 0);

// Medit text (.mesh, .sol)
MeshSlice read_medit_mesh(const Comm& comm, const std::string& path);
FieldSlice read_medit_fields(const Comm& comm, const std::string& path);
void write_medit_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh);
void write_medit_fields(const Comm& comm, const std::string& path, const FieldSlice& fields);

// VTK XML
/// One file for all ranks: tetrahedra, then triangles; cell array "ref"; point arrays from `fields` (may be nullptr).
void write_vtu(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields);
/// <stem>_<rank>.vtu for each rank's cells with the vertices they need, and the index `path`.
void write_pvtu(const Comm& comm, const std::string& path, const MeshSlice& mesh, const FieldSlice* fields);
/// Text as it may stand inside a quoted XML attribute.
std::string xml_escaped(const std::string& s);
/// The XML attributes that describe field i: name, components and their names.
std::string vtk_field_attributes(const FieldSlice& fields, std::size_t i);

}  // namespace skein::io
