// Threads of each process. Which cores they run on is left to OMP_PROC_BIND and OMP_PLACES.
#include "app/threads.hpp"

#include <fmt/core.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <thread>
#include <vector>

namespace skein::app {
namespace {

constexpr int kMostThreads = 1024;

/// Ranks on this machine, as the launcher tells; otherwise all.
int local_ranks(const Comm& comm) {
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && std::atoi(value) > 0) return std::atoi(value);
  }
  return comm.size();
}

/// Cores that the threads of this process may run on: those of OpenMP's places if there are any (the calling thread is
/// bound to one of them then), otherwise those of the process.
int own_cores() {
  std::set<int> cores;
  for (int place = 0; place < omp_get_num_places(); ++place) {
    std::vector<int> ids(static_cast<std::size_t>(omp_get_place_num_procs(place)));
    omp_get_place_proc_ids(place, ids.data());
    cores.insert(ids.begin(), ids.end());
  }
  return cores.empty() ? omp_get_num_procs() : static_cast<int>(cores.size());
}

int threads_of_environment() {
  const char* const value = std::getenv("OMP_NUM_THREADS");
  if (value == nullptr) return 1;
  return static_cast<int>(std::clamp(std::strtol(value, nullptr, 10), 1L, long{kMostThreads}));
}

}  // namespace

void sleep_when_idle(char** argv) {
  for (const char* name : {"OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "KMP_BLOCKTIME"}) {
    if (std::getenv(name) != nullptr) return;
  }
  if (omp_get_proc_bind() != omp_proc_bind_false) return;  // this thread is bound, too, and would stay so
  if (setenv("OMP_WAIT_POLICY", "passive", 1) != 0) return;
  execv("/proc/self/exe", argv);  // where this cannot be, they spin for some milliseconds before they sleep
}

void add_threads_option(CLI::App& verb, int& threads) {
  verb.add_option("--threads", threads, "threads in each process; otherwise as many as OMP_NUM_THREADS says, or one")
      ->check(CLI::Range(1, kMostThreads));
}

int settle_threads(const Comm& comm, int given) {
  return given != kThreadsNotGiven ? given : comm.broadcast(threads_of_environment());
}

void note_threads(const Comm& comm, int threads, PhaseLog& log) {
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  const int wanted = local_ranks(comm) * threads;
  if (cores > 0 && wanted > cores) {
    log.note(fmt::format("note: {} processes of {} threads share {} cores of this machine", local_ranks(comm), threads,
                         cores));
    return;
  }
  const int bound = own_cores();
  if (bound >= threads) return;
  log.note(fmt::format("note: {} threads share {} core{}, to which the process is bound; see mpirun --bind-to none{}",
                       threads, bound, bound == 1 ? "" : "s", omp_get_num_places() > 0 ? " and OMP_PLACES" : ""));
}

}  // namespace skein::app
