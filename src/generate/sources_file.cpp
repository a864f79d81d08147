// Reading of the sources file.
#include "generate/sources_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <sstream>
#include <vector>

namespace skein {
namespace {

struct Kind {
  std::string_view name;
  int corners;
  std::array<std::string_view, 3> corner_key;
};
constexpr std::array<Kind, 3> kKinds{
    {{"point", 1, {"at", "", ""}}, {"line", 2, {"from", "to", ""}}, {"triangle", 3, {"a", "b", "c"}}}};

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
    throw Error(ExitCode::kInput, fmt::format("{}:{}: {}", path_, where.source().begin.line, what));
  }

  [[nodiscard]] double number(const toml::node& node, std::string_view key) const {
    const std::optional<double> v = node.value<double>();  // integers are numbers, too
    if (!v || !node.is_number() || !std::isfinite(*v)) fail(node, fmt::format("'{}' must be a finite number", key));
    return *v;
  }

  [[nodiscard]] const toml::node& need(const toml::table& table, std::string_view key, std::string_view kind) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) fail(table, fmt::format("the [[{}]] source has no '{}'", kind, key));
    return *node;
  }

  [[nodiscard]] Vec3 point(const toml::node& node, std::string_view key) const {
    const toml::array* a = node.as_array();
    if (a == nullptr || a->size() != 3) fail(node, fmt::format("'{}' must be a point [x, y, z]", key));
    return {number((*a)[0], key), number((*a)[1], key), number((*a)[2], key)};
  }

  [[nodiscard]] Source source(const toml::table& table, const Kind& kind) const {
    const std::span<const std::string_view> corner_key(kind.corner_key.data(), static_cast<std::size_t>(kind.corners));
    for (const auto& [key, node] : table) {
      const std::string_view k = key.str();
      const bool known = k == "spacing" || k == "r1" || k == "r2" ||
                         std::find(corner_key.begin(), corner_key.end(), k) != corner_key.end();
      if (!known) fail(node, fmt::format("a [[{}]] source has no key '{}'", kind.name, k));
    }
    Source s;
    s.corners = kind.corners;
    for (std::size_t i = 0; i < corner_key.size(); ++i) {
      s.corner[i] = point(need(table, corner_key[i], kind.name), corner_key[i]);
    }
    const auto& spacing = need(table, "spacing", kind.name);
    const auto& r1 = need(table, "r1", kind.name);
    const auto& r2 = need(table, "r2", kind.name);
    s.spacing = number(spacing, "spacing");
    s.r1 = number(r1, "r1");
    s.r2 = number(r2, "r2");
    if (s.spacing <= 0) fail(spacing, fmt::format("'spacing' is {}, but must be greater than 0", s.spacing));
    if (s.r1 < 0) fail(r1, fmt::format("'r1' is {}, but must not be negative", s.r1));
    if (s.r2 <= s.r1) fail(r2, fmt::format("'r2' is {}, but must be greater than 'r1', which is {}", s.r2, s.r1));
    return s;
  }

  [[nodiscard]] SpacingField field(const toml::table& file) const {
    SpacingField f;
    for (const auto& [key, node] : file) {
      if (key.str() == "size_max") {
        f.size_max = number(node, "size_max");
        if (f.size_max <= 0) fail(node, fmt::format("'size_max' is {}, but must be greater than 0", f.size_max));
        continue;
      }
      const auto kind =
          std::find_if(kKinds.begin(), kKinds.end(), [name = key.str()](const Kind& k) { return k.name == name; });
      if (kind == kKinds.end()) {
        fail(node,
             fmt::format("unknown key '{}'; known are size_max, [[point]], [[line]] and [[triangle]]", key.str()));
      }
      const toml::array* list = node.as_array();
      if (list == nullptr) fail(node, fmt::format("write [[{0}]] instead of [{0}] for a source", kind->name));
      for (const toml::node& entry : *list) {
        if (!entry.is_table()) fail(entry, fmt::format("every '{}' must be a table", kind->name));
        f.sources.push_back(source(*entry.as_table(), *kind));
      }
    }
    return f;
  }

 private:
  const std::string& path_;
};

}  // namespace

SpacingField parse_sources(std::string_view text, const std::string& path) {
  try {
    return Reader(path).field(toml::parse(text));
  } catch (const toml::parse_error& e) {
    throw Error(ExitCode::kInput, fmt::format("{}:{}: {}", path, e.source().begin.line, e.description()));
  }
}

SpacingField read_sources(const Comm& comm, const std::string& path) {
  SpacingField field;
  agree(comm, [&] {
    if (!comm.is_root()) return;
    std::ifstream in(path, std::ios::binary);
    if (!in) throw Error(ExitCode::kInput, fmt::format("{}: cannot open this sources file", path));
    std::ostringstream text;
    text << in.rdbuf();
    if (in.bad() || text.bad()) throw Error(ExitCode::kInput, fmt::format("{}: cannot read this sources file", path));
    field = parse_sources(text.str(), path);
  });
  field.sources = comm.all_gather(field.sources);  // only rank 0 has any
  field.size_max = comm.broadcast(field.size_max);
  return field;
}

}  // namespace skein
