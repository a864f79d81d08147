// Ctrl-C and the like.
#pragma once
#include "comm/comm.hpp"

namespace skein::app {

/// From now on SIGINT and SIGTERM end the process with 128 + the number of the signal, as shells count it, after one
/// line on rank 0; half-written files are removed. Not collective.
void end_cleanly_on_signals(const Comm& comm);

/// Signals end the process as they would without this. For the end of a run: when the ranks end with an error, mpirun
/// sends SIGTERM to those that are not quite there.
void let_signals_be() noexcept;

}  // namespace skein::app
