// Checks of numbers on the command line.
#pragma once
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <string>

namespace skein::app {

/// A finite number greater than 0.
inline CLI::Validator positive() {
  const auto check = [](std::string& word) {
    double value = 0;
    const bool number = CLI::detail::lexical_cast(word, value);
    return number && value > 0 && std::isfinite(value) ? std::string() : "must be a number greater than 0, not " + word;
  };
  return {check, "> 0"};
}

}  // namespace skein::app
