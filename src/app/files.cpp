// Paths of inputs and outputs.
#include "app/files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <map>

#include "comm/file.hpp"

namespace skein::app {
namespace {

void require_ending(ExitCode code, const std::string& path, std::initializer_list<const char*> endings) {
  if (endings.size() == 0 || has_ending(path, endings)) return;
  throw Error(code, fmt::format("{}: unknown file extension; use one of {}", path, fmt::join(endings, ", ")));
}

/// One file under two names, also by links.
bool same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code e;
  if (a.empty() || b.empty()) return false;
  if (fs::exists(a, e) && fs::exists(b, e)) return fs::equivalent(a, b, e);
  return fs::weakly_canonical(fs::absolute(a, e), e) == fs::weakly_canonical(fs::absolute(b, e), e);
}

}  // namespace

bool has_ending(const std::string& path, std::initializer_list<const char*> endings) noexcept {
  for (const char* e : endings) {
    if (path.ends_with(e)) return true;
  }
  return false;
}

void require_input(const Comm& comm, const std::string& path, std::initializer_list<const char*> endings) {
  agree(comm, [&] { require_ending(ExitCode::kInput, path, endings); });
  const InputFile probe(comm, path);
}

void require_output(const Comm& comm, const std::string& path, std::initializer_list<const char*> endings) {
  if (path.empty()) return;
  agree(comm, [&] { require_ending(ExitCode::kOutput, path, endings); });
  const OutputFile probe(comm, path);  // made under a temporary name and removed again
}

MeshSlice read_mesh_noting(const Comm& comm, const std::string& path,
                           const std::function<void(const std::string&)>& note) {
  MeshSlice mesh = read_mesh(comm, path);
  if (!mesh.passed_over.empty())
    note(fmt::format("note: {}: sections that are not kept: {}", path, fmt::join(mesh.passed_over, ", ")));
  return mesh;
}

void require_tets(const Comm& comm, const MeshSlice& mesh) {
  agree(comm, [&] {
    if (mesh.tets.total == 0)
      throw Error(ExitCode::kInput,
                  mesh.path + ": no tetrahedra; skein check judges surfaces, skein generate fills them");
  });
}

void require_distinct(const Comm& comm, const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                      InputFiles files) {
  agree(comm, [&] {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (same_file(outputs[i], outputs[j]))
          throw Error(ExitCode::kUsage, fmt::format("{} is the name of two outputs; give each its own", outputs[i]));
      }
      for (const std::string& in : inputs) {
        if (files == InputFiles::kKept && same_file(outputs[i], in))
          throw Error(ExitCode::kUsage,
                      fmt::format("the output {} is an input; give it another name, or --overwrite-input", outputs[i]));
      }
    }
  });
}

void add_overwrite_option(CLI::App& verb, InputFiles& files) {
  verb.add_flag_callback(
      "--overwrite-input", [&files] { files = InputFiles::kMayBeOverwritten; }, "an output may replace an input");
}

void add_format_option(CLI::App& verb, GmfVersion& version) {
  static const std::map<std::string, GmfVersion> kVersions{
      {"2", GmfVersion::k2}, {"3", GmfVersion::k3}, {"4", GmfVersion::k4}};
  verb.add_option_function<std::string>(
          "--format-version", [&version](const std::string& v) { version = kVersions.at(v); },
          "version of .meshb and .solb: 2, 3 or 4 (else: the lowest that holds the file)")
      ->check(CLI::IsMember({"2", "3", "4"}));
}

}  // namespace skein::app
