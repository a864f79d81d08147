// The fields that travel with the mesh: --field-in and --field-out.
#pragma once
#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "app/run_report.hpp"
#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein::app {

struct FieldOptions {
  std::vector<std::string> in;  ///< solutions at the vertices of the input
  std::string out;
};
void add_field_options(CLI::App& verb, FieldOptions& o);

/// Collective. Throws Error(kUsage) when one of the options needs the other (`output`, the mesh, may hold fields
/// itself), and Error(kInput) or Error(kOutput) when a file is missing or cannot be written.
void require_fields(const Comm& comm, const FieldOptions& o, const std::string& output);

/// Collective. Reads the files and puts their numbers behind `values`, vertex by vertex; without --field-in nothing
/// happens. Tells what the fields of the new mesh are. Throws Error(kInput) when a file has not one value per vertex of
/// `mesh`.
FieldsOut read_fields_behind(const Comm& comm, const MeshSlice& mesh, const FieldOptions& o, FieldSlice& values);

/// Collective. The fields of several files side by side, named after their files. Throws Error(kInput) when a file has
/// not one value per vertex of `mesh`.
FieldSlice read_together(const Comm& comm, const MeshSlice& mesh, const std::vector<std::string>& paths);

}  // namespace skein::app
