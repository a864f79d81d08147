// Words on the command line that nobody knows.
#include "app/spelling.hpp"

#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace skein::app {
namespace {

constexpr std::size_t kFewChanges = 2;
constexpr std::size_t kPrefix = 3;  ///< letters from which on the beginning of a name is enough

/// Options of other programs, and what does the same here.
constexpr std::array<std::pair<std::string_view, std::string_view>, 24> kElsewhere{{
    {"hsiz", "size"},
    {"hgrad", "gradation"},
    {"hgradreq", "gradation"},
    {"ar", "ridge-angle"},
    {"angle", "ridge-angle"},
    {"nosurf", "no-surface"},
    {"sol", "metric"},
    {"met", "metric"},
    {"out", "output"},
    {"hausd", "deviation"},
    {"niter", "rounds"},
    {"sweeps", "rounds"},
    {"optimLES", "optim"},
    {"norm-power", "norm"},
    {"aspect-ratio", "aspect-max"},
    {"interpolant", "field"},
    {"clmax", "hmax"},
    {"clmin", "hmin"},
    {"nt", "threads"},
    {"format", "format-version"},
    {"field-scalar", "field"},
    {"centralize", "threads"},
    {"rmc", "merge"},
    {"mesh-size", "elements"},
}};

bool is_number(const std::string& word) {
  return word.size() > 1 && (std::isdigit(static_cast<unsigned char>(word[1])) != 0 || word[1] == '.');
}

std::vector<std::string> long_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* o : command.get_options()) {
    names.insert(names.end(), o->get_lnames().begin(), o->get_lnames().end());
  }
  return names;
}

const CLI::Option* find_option(const CLI::App& command, const std::string& dashed) {
  return command.get_option_no_throw(dashed);
}

std::string meant(const CLI::App& command, const std::string& word) {
  const auto names = long_names(command);
  for (const auto& [theirs, ours] : kElsewhere) {
    if (word == theirs && std::ranges::find(names, ours) != names.end()) return std::string(ours);
  }
  return nearest(word, names);
}

[[noreturn]] void refuse_option(const CLI::App& command, const std::string& word) {
  const std::string name = word.substr(word.find_first_not_of('-'));
  const std::string other = meant(command, name.substr(0, name.find('=')));
  throw Error(ExitCode::kUsage,
              fmt::format("{}: there is no option {}; {}ee: skein {} --help", command.get_name(), word,
                          other.empty() ? "s" : fmt::format("did you mean --{}? S", other), command.get_name()));
}

[[noreturn]] void refuse_command(const CLI::App& cli, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* sub : cli.get_subcommands({})) names.push_back(sub->get_name());
  const std::string other = nearest(word, names);
  throw Error(ExitCode::kUsage, fmt::format("'{}' is not a command of skein; {}ee: skein --help", word,
                                            other.empty() ? "s" : fmt::format("did you mean '{}'? S", other)));
}

/// -oFILE; -out is none, as a file has a dot or a slash.
bool is_joined_output(const CLI::App& command, const std::string& word) {
  return word.starts_with("-o") && word.find_first_of("./", 2) != std::string::npos &&
         find_option(command, "-o") != nullptr;
}

/// Whether the next word belongs to this one, an option. Throws when the command does not have it.
bool takes_next(const CLI::App& command, const std::string& word) {
  const bool long_form = word.starts_with("--");
  if (!long_form && is_joined_output(command, word)) return false;
  const std::string name = long_form ? word.substr(0, word.find('=')) : word;
  const CLI::Option* o = long_form || word.size() == 2 ? find_option(command, name) : nullptr;
  if (o == nullptr) refuse_option(command, word);
  return o->get_items_expected_min() > 0 && name == word;
}

}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
  for (const std::string& k : known) {
    if (word.size() >= kPrefix && k.starts_with(word)) return k;
  }
  std::string best;
  std::size_t least = word.size();
  for (const std::string& k : known) {
    const std::size_t d = edit_distance(word, k);
    const std::size_t few = std::min(std::max(kFewChanges, 2 * k.size() / 5), word.size() / 2 + 1);
    if (d <= few && d < least) least = d, best = k;
  }
  return best;
}

void refuse_misspelt(const CLI::App& cli, std::span<char* const> args) {
  if (args.size() < 2) return;
  const std::string first = args[1];
  if (first.starts_with('-')) {
    if (cli.get_option_no_throw(first) == nullptr) {
      throw Error(ExitCode::kUsage, fmt::format("the command comes before {}; see: skein --help", first));
    }
    return;
  }
  const auto commands = cli.get_subcommands({});
  const auto at = std::ranges::find(commands, first, [](const CLI::App* c) { return c->get_name(); });
  if (at == commands.end()) refuse_command(cli, first);
  const CLI::App* command = *at;
  for (std::size_t i = 2; i < args.size(); ++i) {
    const std::string word = args[i];
    if (word == "--") return;
    if (word.size() < 2 || word[0] != '-' || is_number(word)) continue;
    if (takes_next(*command, word)) ++i;
  }
}

}  // namespace skein::app
