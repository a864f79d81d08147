// Methods to TOML and back, over the one list of numbers.
#include "adapt/method_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <vector>

#include "base/text.hpp"
#include "kernel/method_numbers.hpp"

namespace skein {
namespace {

constexpr std::array<std::string_view, 2> kPoints{"edges", "centroids"}, kSmoothing{"quality", "springs"};

std::vector<std::string> all_keys() {
  std::vector<std::string> keys{"preset", "points", "smoothing"};
  const Method method;
  for_each_number(method,
                  [&](std::string_view name, auto&, double, double, std::string_view) { keys.emplace_back(name); });
  return keys;
}

std::string nearest_key(const std::string& key) {
  const auto keys = all_keys();
  return *std::min_element(keys.begin(), keys.end(), [&](const std::string& a, const std::string& b) {
    return edit_distance(key, a) < edit_distance(key, b);
  });
}

class Reader {
 public:
  Reader(const toml::table& root, const std::string& path) : root_(root), path_(path) {}

  Method run() {
    refuse_unknown();
    Method m = find_preset(text("preset", "default")).method;
    m.points = choice("points", kPoints, m.points);
    m.smoothing = choice("smoothing", kSmoothing, m.smoothing);
    for_each_number(m, [&](std::string_view name, auto& number, double least, double most, std::string_view) {
      take(name, number, least, most);
    });
    return m;
  }

 private:
  [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
    throw Error(ExitCode::kInput, fmt::format("{}:{}: {}", path_, where.source().begin.line, what));
  }

  void refuse_unknown() const {
    const auto keys = all_keys();
    const std::set<std::string> known(keys.begin(), keys.end());
    const auto require = [&](const std::string& key, const toml::node& node) {
      if (!known.contains(key)) fail(node, fmt::format("there is no '{}'; is '{}' meant?", key, nearest_key(key)));
    };
    for (const auto& [key, node] : root_) {
      const std::string name(key.str());
      const toml::table* section = node.as_table();
      if (section == nullptr) {
        require(name, node);
      } else {
        for (const auto& [inner, value] : *section) require(fmt::format("{}.{}", name, inner.str()), value);
      }
    }
  }

  [[nodiscard]] const toml::node* find(std::string_view name) const { return root_.at_path(name).node(); }

  [[nodiscard]] std::string text(std::string_view key, std::string_view otherwise) const {
    const toml::node* node = find(key);
    if (node == nullptr) return std::string(otherwise);
    if (!node->is_string()) fail(*node, fmt::format("'{}' must be a text", key));
    return std::string(*node->value<std::string_view>());
  }

  template <class Enum>
  [[nodiscard]] Enum choice(std::string_view key, const std::array<std::string_view, 2>& names, Enum otherwise) const {
    const std::string value = text(key, names[static_cast<std::size_t>(otherwise)]);
    const auto at = std::find(names.begin(), names.end(), value);
    if (at == names.end()) fail(*find(key), fmt::format("'{}' must be \"{}\" or \"{}\"", key, names[0], names[1]));
    return static_cast<Enum>(at - names.begin());
  }

  template <class Number>
  void take(std::string_view name, Number& number, double least, double most) const {
    const toml::node* node = find(name);
    if (node == nullptr) return;
    constexpr bool kWhole = std::is_same_v<Number, int>;
    const auto value = node->value<double>();  // whole numbers are numbers, too
    if (!value || !node->is_number() || !std::isfinite(*value) || (kWhole && !node->is_integer())) {
      fail(*node, fmt::format("'{}' must be a {}", name, kWhole ? "whole number" : "finite number"));
    }
    if (*value < least || *value > most) {
      fail(*node, fmt::format("'{}' is {}; it must be from {} to {}", name, *value, least, most));
    }
    number = static_cast<Number>(*value);
  }

  const toml::table& root_;
  const std::string& path_;
};

}  // namespace

const Preset& find_preset(std::string_view name) {
  std::string names;
  for (const Preset& p : presets()) {
    if (p.name == name) return p;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", p.name);
  }
  throw Error(ExitCode::kUsage, fmt::format("there is no method '{}'; there are: {}", name, names));
}

std::string method_to_toml(const Method& method, std::string_view preset) {
  std::string out = "# Method of skein adapt. Lengths are metric (1 is ideal), qualities from 0 to 1.\n";
  out += fmt::format("preset = \"{}\"  # what this starts from; what is not given is as it has it\n", preset);
  out += fmt::format("points = \"{}\"  # created along long edges, or at centroids (\"centroids\") [35.2.3.2]\n",
                     kPoints[static_cast<std::size_t>(method.points)]);
  out += fmt::format("smoothing = \"{}\"  # to the best quality, or by springs (\"springs\") [35.3.1]\n",
                     kSmoothing[static_cast<std::size_t>(method.smoothing)]);
  std::string_view section;
  for_each_number(method, [&](std::string_view name, const auto& number, double, double, std::string_view what) {
    const std::size_t dot = name.find('.');
    if (name.substr(0, dot) != section) {
      section = name.substr(0, dot);
      out += fmt::format("\n[{}]\n", section);
    }
    std::string value = fmt::format("{}", number);
    if (!std::is_same_v<std::remove_cvref_t<decltype(number)>, int> && value.find_first_of(".e") == std::string::npos) {
      value += ".0";
    }
    out += fmt::format("{} = {}  # {}\n", name.substr(dot + 1), value, what);
  });
  return out;
}

Method parse_method(std::string_view text, const std::string& path) {
  try {
    return Reader(toml::parse(text), path).run();
  } catch (const toml::parse_error& e) {
    throw Error(ExitCode::kInput, fmt::format("{}:{}: {}", path, e.source().begin.line, e.description()));
  }
}

Method read_method(const Comm& comm, const std::string& path) {
  std::string text;
  agree(comm, [&] {
    if (!comm.is_root()) return;
    std::ifstream file(path, std::ios::binary);
    std::ostringstream all;
    if (file) all << file.rdbuf();
    if (!file || !all) throw Error(ExitCode::kInput, fmt::format("{}: cannot be read", path));
    text = all.str();
  });
  text = comm.broadcast(text);
  Method method;
  agree(comm, [&] { method = parse_method(text, path); });
  return method;
}

}  // namespace skein
