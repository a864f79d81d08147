// Threads of each process: how many, and whether there are cores for them.
#pragma once
#include <CLI/App.hpp>

#include "comm/comm.hpp"
#include "comm/phase_log.hpp"

namespace skein::app {

/// Makes OpenMP's threads sleep while they have nothing to do, unless the environment says how they shall wait
/// (OMP_WAIT_POLICY, GOMP_SPINCOUNT, KMP_BLOCKTIME) or binds them to cores, which are theirs then. As OpenMP reads its
/// environment when the program is loaded, this may start the program again in this process. To be called first of all.
void sleep_when_idle(char** argv);

inline constexpr int kThreadsNotGiven = 0;

/// --threads.
void add_threads_option(CLI::App& verb, int& threads);

/// Collective. `given`, or else what OMP_NUM_THREADS says on rank 0 (the first number of a list), or else 1: the same
/// on every rank, because the result depends on it. OpenMP alone would take all cores.
int settle_threads(const Comm& comm, int given);

/// Rank 0 says when there are more threads than cores, on the machine or of those it is bound to. Collective.
void note_threads(const Comm& comm, int threads, PhaseLog& log);

}  // namespace skein::app
