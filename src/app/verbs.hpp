// The verbs of the command line: each file wires its options to the libraries.
#pragma once
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <functional>

#include "comm/comm.hpp"

namespace skein::app {

/// What the chosen verb does. Collective. Gives the exit code; user errors are thrown through agree().
using Run = std::function<ExitCode(const Comm&)>;

// Each adds its subcommand to `cli`; parsing the command line sets `run`, when the verb is the chosen one.
void add_adapt(CLI::App& cli, Run& run);
void add_check(CLI::App& cli, Run& run);
void add_convert(CLI::App& cli, Run& run);
void add_generate(CLI::App& cli, Run& run);
void add_partition(CLI::App& cli, Run& run);
void add_stats(CLI::App& cli, Run& run);

}  // namespace skein::app
