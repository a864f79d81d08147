// Help pages: 80 columns, options in groups.
#pragma once
#include <CLI/App.hpp>
#include <initializer_list>

namespace skein::app {

/// Makes the help of the program and of its commands fit 80 columns. To be called before commands are added.
void use_narrow_help(CLI::App& cli);

/// Puts the options of these names under a title of their own.
void group(CLI::App& command, const char* title, std::initializer_list<const char*> names);

}  // namespace skein::app
