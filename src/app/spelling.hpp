// Words on the command line that nobody knows: what may be meant.
#pragma once
#include <CLI/App.hpp>
#include <span>
#include <string>
#include <vector>

namespace skein::app {

/// The word that `word` may be a slip of: one that begins with it, or needs few changes; empty if there is none.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

/// Throws Error(kUsage) for a command that there is not, and for an option that the command does not have, each with
/// what may be meant: the nearest name, or what Mmg, ParMmg, refine and Gmsh call by this name. Long options with a
/// single dash are refused, too: CLI11 takes -hmax for -h and prints the help. `args` as main() has them.
void refuse_misspelt(const CLI::App& cli, std::span<char* const> args);

}  // namespace skein::app
