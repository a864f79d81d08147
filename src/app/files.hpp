// Paths of inputs and outputs: what can be said about them before the work begins.
#pragma once
#include <CLI/App.hpp>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "io/mesh_io.hpp"

namespace skein::app {

inline constexpr std::initializer_list<const char*> kMeshInputs{".mesh", ".meshb"};
inline constexpr std::initializer_list<const char*> kMeshOutputs{".mesh", ".meshb", ".vtu", ".pvtu"};
inline constexpr std::initializer_list<const char*> kFields{".sol", ".solb"};

bool has_ending(const std::string& path, std::initializer_list<const char*> endings) noexcept;

/// Collective. Throws Error(kInput) unless the file is there and the ending is one of these.
void require_input(const Comm& comm, const std::string& path, std::initializer_list<const char*> endings);
/// Collective. Throws Error(kOutput) unless a file with this name can be made (an old one stays as it is, and
/// nothing is left behind) and the ending is one of these; an empty list takes any ending. An empty path is no output.
void require_output(const Comm& comm, const std::string& path, std::initializer_list<const char*> endings);

/// Collective. read_mesh(), and a note of the sections of the file that are not kept.
MeshSlice read_mesh_noting(const Comm& comm, const std::string& path,
                           const std::function<void(const std::string&)>& note);
/// Collective. Throws Error(kInput) unless the mesh has tetrahedra.
void require_tets(const Comm& comm, const MeshSlice& mesh);

/// --overwrite-input.
enum class InputFiles { kKept, kMayBeOverwritten };
/// Collective. Throws Error(kUsage) when two outputs are one file, or, unless they may be overwritten, an output is an
/// input. Empty paths are none.
void require_distinct(const Comm& comm, const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                      InputFiles files);
void add_overwrite_option(CLI::App& verb, InputFiles& files);

/// --format-version.
void add_format_option(CLI::App& verb, GmfVersion& version);

}  // namespace skein::app
