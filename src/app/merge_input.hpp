// The option --merge: near vertices of the input become one.
#pragma once
#include <CLI/App.hpp>
#include <functional>
#include <optional>
#include <string>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein::app {

void add_merge_option(CLI::App& verb, std::optional<double>& tolerance);

/// Collective. merge_vertices(), if there is a tolerance; `note` is told what it did. Messages about the mesh name it
/// "PATH after --merge" then, because numbers have closed up.
void merge_input(const Comm& comm, std::optional<double> tolerance, MeshSlice& mesh, FieldSlice* values,
                 const std::function<void(const std::string&)>& note);

}  // namespace skein::app
