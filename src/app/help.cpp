// Help pages.
#include "app/help.hpp"

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <sstream>
#include <string>

namespace skein::app {
namespace {

constexpr std::size_t kWidth = 80, kNames = 26;

/// The words in lines of at most `width` letters, each further line behind `indent` spaces.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::istringstream words(text);
  std::string out, word;
  std::size_t column = 0;
  while (words >> word) {
    if (column > 0 && column + 1 + word.size() > width) {
      out += '\n' + std::string(indent, ' ');
      column = 0;
    } else if (column > 0) {
      out += ' ', ++column;
    }
    out += word, column += word.size();
  }
  return out;
}

class NarrowFormatter : public CLI::Formatter {
 public:
  NarrowFormatter() { column_width(kNames); }
  std::string make_option(const CLI::Option* o, bool is_positional) const override {
    const std::string name = "  " + make_option_name(o, is_positional) + make_option_opts(o);
    const std::string text = wrapped(o->get_description(), kWidth - kNames, kNames);
    const std::string gap =
        name.size() + 1 < kNames ? std::string(kNames - name.size(), ' ') : '\n' + std::string(kNames, ' ');
    return name + gap + text + '\n';
  }
  /// What kind of value follows, and no more: descriptions say the rest.
  std::string make_option_opts(const CLI::Option* o) const override {
    if (o->get_type_size() == 0 || o->get_positional()) return "";
    const std::string type = o->get_type_name();
    const std::string first = type.substr(0, type.find(':'));
    return first == "FLOAT"                    ? " X"
           : first == "INT" || first == "UINT" ? " N"
           : first == "TEXT"                   ? (type.find('{') == std::string::npos ? " FILE" : " WORD")
                                               : " " + first;
  }
  std::string make_usage(const CLI::App* app, std::string name) const override {
    const bool command = app->get_parent() != nullptr;
    std::string usage = "Usage: skein " + (command ? app->get_name() + " [options]" : std::string("COMMAND [options]"));
    for (const CLI::Option* o : app->get_options([](const CLI::Option* p) { return p->get_positional(); })) {
      usage += " " + o->get_name(true);
    }
    static_cast<void>(name);
    return usage + "\n";
  }
  std::string make_description(const CLI::App* app) const override {
    return wrapped(app->get_description(), kWidth, 0) + "\n";
  }
  std::string make_footer(const CLI::App* app) const override {
    const std::string footer = app->get_footer();
    std::string out;
    std::istringstream lines(footer);
    for (std::string line; std::getline(lines, line);) out += wrapped(line, kWidth, 2) + "\n";
    return footer.empty() ? "" : out;
  }
};

}  // namespace

void use_narrow_help(CLI::App& cli) { cli.formatter(std::make_shared<NarrowFormatter>()); }

void group(CLI::App& command, const char* title, std::initializer_list<const char*> names) {
  for (const char* name : names) command.get_option(name)->group(title);
}

}  // namespace skein::app
