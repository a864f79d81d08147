// Ctrl-C and the like.
#pragma once
#include "comm/comm.hpp"

namespace skein::app {

/// From now on SIGINT and SIGTERM end the process with 128 + the number of the signal, as shells count it, after one
/// line on rank 0; half-written files are removed. Not collective.
void end_cleanly_on_signals(const Comm& comm);

}  // namespace skein::app
