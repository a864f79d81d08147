// The program skein: command line, the one error line, the exit code.
#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <sstream>
#include <thread>

#include "app/help.hpp"
#include "app/interrupt.hpp"
#include "app/large_blocks.hpp"
#include "app/spelling.hpp"
#include "app/threads.hpp"
#include "app/verbs.hpp"

namespace skein::app {
namespace {

void print_error(std::string line) {
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fflush(stdout);
  fmt::print(stderr, "skein: error: {}\n", line);
  std::fflush(stderr);
}

/// Every rank parses the same command line, so every rank comes to the same result; rank 0 speaks.
ExitCode report_parse_result(const Comm& comm, const CLI::App& cli, const CLI::ParseError& e) {
  std::ostringstream out, err;
  const int code = cli.exit(e, out, err);  // 0 for --help and --version
  if (!comm.is_root()) return code == 0 ? ExitCode::kOk : ExitCode::kUsage;
  if (code == 0) {
    fmt::print("{}", out.str());
    return ExitCode::kOk;
  }
  std::string verb;
  for (const CLI::App* sub : cli.get_subcommands()) verb = " " + sub->get_name();
  print_error(fmt::format("{}; see: skein{} --help", verb.empty() ? "a command is required" : e.what(), verb));
  return ExitCode::kUsage;
}

/// An error that may be this rank's alone: the others may wait for it in a collective. Those who have it, too, meet at
/// the barrier of `farewell`; if they do not come soon, this rank speaks for itself and ends the run.
ExitCode fail_perhaps_alone(const Comm& comm, const Comm& farewell, ExitCode code, const std::string& line) {
  std::atomic<bool> together = comm.size() == 1;
  std::thread watch([&] {
    for (int i = 0; i < 30 && !together; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (together) return;
    print_error(fmt::format("{} (rank {} of {})", line, num(comm.rank()), comm.size()));
    abort_all(code);
  });
  if (!together) farewell.barrier();
  together = true;
  watch.join();
  if (comm.is_root()) print_error(line);
  return code;
}

ExitCode parse_and_run(const Comm& comm, int argc, char** argv) {
  CLI::App cli{"Skein remeshes tetrahedral meshes in parallel."};
  use_narrow_help(cli);
  cli.set_version_flag("--version", "skein " SKEIN_VERSION);
  cli.require_subcommand(1);
  cli.footer(
      "Each command has its own --help. To use N processes: mpirun -n N skein ...\n"
      "Exit codes: 0 done, 1 mesh not valid, 2 command line, 3 input, 4 output, 5 internal, 130 interrupted.");
  Run run;
  add_adapt(cli, run);
  add_generate(cli, run);
  add_check(cli, run);
  add_stats(cli, run);
  add_convert(cli, run);
  add_partition(cli, run);
  for (CLI::App* command : cli.get_subcommands({})) command->group("Commands");
  agree(comm, [&] { refuse_misspelt(cli, {argv, static_cast<std::size_t>(argc)}); });
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return report_parse_result(comm, cli, e);
  }
  return run(comm);
}

ExitCode guarded(const Comm& comm, const Comm& farewell, int argc, char** argv) {
  const auto fail = [&](ExitCode code, const std::string& line) {
    return fail_perhaps_alone(comm, farewell, code, line);
  };
  try {
    return parse_and_run(comm, argc, argv);
  } catch (const AgreedError& e) {
    if (comm.is_root()) print_error(e.what());
    return e.code();
  } catch (const Error& e) {
    return fail(e.code(), e.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::kInternal, "out of memory; use more ranks on more machines, or a coarser mesh");
  } catch (const std::exception& e) {
    return fail(ExitCode::kInternal, fmt::format("internal error, please report it: {}", e.what()));
  }
}

}  // namespace
}  // namespace skein::app

int main(int argc, char** argv) {
  skein::app::sleep_when_idle(argv);
  skein::app::use_large_blocks();
  skein::Environment environment(argc, argv);
  const skein::Comm comm = skein::Comm::world();
  skein::app::end_cleanly_on_signals(comm);
  const skein::Comm farewell = skein::Comm::world();  // free of messages of work that was broken off
  const skein::ExitCode code = skein::app::guarded(comm, farewell, argc, argv);
  skein::app::let_signals_be();
  farewell.barrier();  // rank 0 has spoken before any rank ends with an error, which makes mpirun end the others
  return static_cast<int>(code);
}
