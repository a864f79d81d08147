// Ctrl-C and the like. A handler may call only functions that POSIX lists as safe.
#include "app/interrupt.hpp"

#include <unistd.h>

#include <csignal>
#include <string_view>

#include "comm/file.hpp"

namespace skein::app {
namespace {

volatile std::sig_atomic_t speaks = 0;

void end_now(int signal) {
  constexpr std::string_view kLine = "\nskein: error: interrupted; nothing was written\n";
  remove_temporary_files();
  if (speaks != 0) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kLine.data(), kLine.size());
  }
  ::_exit(128 + signal);
}

}  // namespace

void end_cleanly_on_signals(const Comm& comm) {
  speaks = comm.is_root() ? 1 : 0;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, end_now);
}

void let_signals_be() noexcept {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
}

}  // namespace skein::app
