// Paths of inputs and outputs.
#include "app/files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <map>

#include "comm/file.hpp"

namespace skein::app {
namespace {

void require_ending(ExitCode code, const std::string& path, std::initializer_list<const char*> endings) {
  if (endings.size() == 0 || has_ending(path, endings)) return;
  throw Error(code, fmt::format("{}: unknown ending; use one of {}", path, fmt::join(endings, ", ")));
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

void add_format_option(CLI::App& verb, GmfVersion& version) {
  static const std::map<std::string, GmfVersion> kVersions{
      {"2", GmfVersion::k2}, {"3", GmfVersion::k3}, {"4", GmfVersion::k4}};
  verb.add_option_function<std::string>(
          "--format-version", [&version](const std::string& v) { version = kVersions.at(v); },
          "version of .meshb and .solb: 2, 3 or 4 (else: the lowest that holds the file)")
      ->check(CLI::IsMember({"2", "3", "4"}));
}

}  // namespace skein::app
