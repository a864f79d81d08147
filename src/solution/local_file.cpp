// Reading of the file of local sizes.
#include "solution/local_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "base/error.hpp"

namespace skein {
namespace {

constexpr std::array<std::string_view, 6> kKeys{"ref", "name", "size", "hmin", "hmax", "freeze"};

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  [[nodiscard]] std::vector<LocalRule> rules(const toml::table& file) {
    for (const auto& [key, node] : file) {
      if (key.str() == "names") read_names(node);
    }
    std::vector<LocalRule> out;
    for (const auto& [key, node] : file) {
      if (key.str() == "names") continue;
      if (key.str() != "patch" && key.str() != "region")
        fail(node, fmt::format("unknown key '{}'; known are [[patch]], [[region]] and [names]", key.str()));
      const toml::array* list = node.as_array();
      if (list == nullptr) fail(node, fmt::format("write [[{0}]] instead of [{0}]", key.str()));
      for (const toml::node& entry : *list) {
        if (!entry.is_table()) fail(entry, fmt::format("every '{}' must be a table", key.str()));
        out.push_back(rule(*entry.as_table()));
        out.back().on = key.str() == "patch" ? LocalRule::On::kPatches : LocalRule::On::kRegions;
      }
    }
    return out;
  }

 private:
  [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
    throw Error(ExitCode::kInput, fmt::format("{}:{}: {}", path_, where.source().begin.line, what));
  }

  [[nodiscard]] std::vector<std::int32_t> refs(const toml::node& node) const {
    std::vector<std::int32_t> out;
    const auto add = [&](const toml::node& n) {
      const std::optional<std::int64_t> v = n.value_exact<std::int64_t>();
      if (!v || *v < INT32_MIN || *v > INT32_MAX) fail(n, "a reference must be a whole number of 32 bits");
      out.push_back(static_cast<std::int32_t>(*v));
    };
    if (const toml::array* list = node.as_array()) {
      for (const toml::node& n : *list) add(n);
    } else {
      add(node);
    }
    if (out.empty()) fail(node, "the list of references is empty");
    return out;
  }

  void read_names(const toml::node& node) {
    const toml::table* table = node.as_table();
    if (table == nullptr) fail(node, "write [names], with lines NAME = reference");
    for (const auto& [name, value] : *table) names_[std::string(name.str())] = refs(value);
  }

  [[nodiscard]] std::vector<std::int32_t> named(const toml::node& node) const {
    const std::optional<std::string> name = node.value<std::string>();
    if (!name) fail(node, "'name' must be a text in quotes");
    const auto at = names_.find(*name);
    if (at == names_.end()) fail(node, fmt::format("the name '{}' is not in [names]", *name));
    return at->second;
  }

  [[nodiscard]] double length(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return 0;
    const std::optional<double> v = node->value<double>();
    if (!v || !node->is_number() || !std::isfinite(*v) || !(*v > 0))
      fail(*node, fmt::format("'{}' must be a number greater than 0", key));
    return *v;
  }

  [[nodiscard]] LocalRule rule(const toml::table& table) const {
    for (const auto& [key, node] : table) {
      if (std::ranges::find(kKeys, key.str()) == kKeys.end())
        fail(node, fmt::format("unknown key '{}'; known are {}", key.str(), fmt::join(kKeys, ", ")));
    }
    const toml::node *ref = table.get("ref"), *name = table.get("name");
    if ((ref == nullptr) == (name == nullptr)) fail(table, "give either 'ref' or 'name'");
    LocalRule r;
    r.where = fmt::format("{}:{}", path_, table.source().begin.line);
    r.refs = ref != nullptr ? refs(*ref) : named(*name);
    r.h_min = length(table, "hmin"), r.h_max = length(table, "hmax");
    const double size = length(table, "size");
    if (size > 0 && (r.h_min > 0 || r.h_max > 0)) fail(table, "give 'size' or 'hmin' and 'hmax', not both");
    if (size > 0) r.h_min = r.h_max = size;
    if (r.h_max > 0 && r.h_min > r.h_max)
      fail(table, fmt::format("'hmin' {} is greater than 'hmax' {}", r.h_min, r.h_max));
    if (const toml::node* freeze = table.get("freeze")) {
      if (!freeze->is_boolean()) fail(*freeze, "'freeze' must be true or false");
      if (freeze->value<bool>() == true) r.change = LocalRule::Change::kNone;
    }
    if (r.h_min == 0 && r.h_max == 0 && r.change == LocalRule::Change::kAllowed)
      fail(table, "this entry says nothing: give 'size', 'hmin', 'hmax' or 'freeze'");
    return r;
  }

  const std::string& path_;
  std::map<std::string, std::vector<std::int32_t>> names_;
};

}  // namespace

std::vector<LocalRule> parse_local(std::string_view text, const std::string& path) {
  try {
    return Reader(path).rules(toml::parse(text));
  } catch (const toml::parse_error& e) {
    throw Error(ExitCode::kInput, fmt::format("{}:{}: {}", path, e.source().begin.line, e.description()));
  }
}

std::vector<LocalRule> read_local(const Comm& comm, const std::string& path) {
  std::string text;
  agree(comm, [&] {
    if (!comm.is_root()) return;
    std::ifstream in(path, std::ios::binary);
    if (!in) throw Error(ExitCode::kInput, fmt::format("{}: cannot open this file of local sizes", path));
    text.assign(std::istreambuf_iterator<char>(in), {});
  });
  text = comm.broadcast(text);
  std::vector<LocalRule> rules;
  agree(comm, [&] { rules = parse_local(text, path); });
  return rules;
}

}  // namespace skein
