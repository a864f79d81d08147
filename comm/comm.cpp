// Environment, Comm's life, clocks.
#include "comm/comm.hpp"

#include <malloc.h>
#include <sys/resource.h>
#include <time.h>

#include <chrono>
#include <cstdlib>
#include <exception>
#include <string_view>
#include <utility>

#include "comm/impl.hpp"

namespace skein {
namespace {

bool mpi_running() noexcept {
  int started = 0, finished = 0;
  MPI_Initialized(&started);
  MPI_Finalized(&finished);
  return started != 0 && finished == 0;
}

/// The value of a variable that the launcher sets, or nothing.
std::string_view from_launcher(const char* name) noexcept {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

/// True if no message will leave this machine: one process without a launcher, or all that Open MPI's has started.
bool all_on_this_machine() noexcept {
  for (const char* name : {"PMI_RANK", "PMI_SIZE", "SLURM_PROCID"}) {
    if (!from_launcher(name).empty()) return false;  // other launchers do not tell
  }
  if (from_launcher("OMPI_COMM_WORLD_SIZE").empty()) return from_launcher("PMIX_RANK").empty();
  return from_launcher("OMPI_COMM_WORLD_SIZE") == from_launcher("OMPI_COMM_WORLD_LOCAL_SIZE");
}

/// Open MPI looks for networks for a fifth of a second before it finds that shared memory will do. Whoever has chosen
/// otherwise in the environment keeps that.
void skip_networks() noexcept {
  ::setenv("OMPI_MCA_pml", "ob1", 0);
  ::setenv("OMPI_MCA_btl", "self,vader", 0);
}

}  // namespace

namespace detail {

Comm duplicate(MPI_Comm from) {
  std::unique_ptr<Comm::Impl, Comm::Freed> impl(std::make_unique<Comm::Impl>().release());
  MPI_Comm_dup(from, &impl->mpi);
  MPI_Comm_rank(impl->mpi, &impl->rank);
  MPI_Comm_size(impl->mpi, &impl->size);
  return Comm(std::move(impl));
}

void abandon(Comm& comm) noexcept { comm.impl().mpi = MPI_COMM_NULL; }

}  // namespace detail

Environment::Environment(int& argc, char**& argv) {
  if (all_on_this_machine()) skip_networks();
  int level = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
}

Environment::~Environment() {
  if (!mpi_running()) return;
  // An exception passes: the other ranks may wait for this one in a collective, and MPI_Finalize would wait for them.
  if (std::uncaught_exceptions() > 0) abort_all(ExitCode::kInternal);
  MPI_Finalize();
}

void abort_all(ExitCode code) noexcept {
  if (mpi_running()) MPI_Abort(MPI_COMM_WORLD, static_cast<int>(code));
  std::_Exit(static_cast<int>(code));
}

void Comm::Freed::operator()(Impl* impl) const noexcept {
  const std::unique_ptr<Impl> owned(impl);
  if (impl->mpi != MPI_COMM_NULL && mpi_running()) MPI_Comm_free(&impl->mpi);
}
Comm::Comm(std::unique_ptr<Impl, Freed> impl) noexcept : impl_(std::move(impl)) {}
Comm Comm::world() { return detail::duplicate(MPI_COMM_WORLD); }
Comm Comm::self() { return detail::duplicate(MPI_COMM_SELF); }
Comm Comm::from(MpiHandle handle) { return detail::duplicate(*static_cast<const MPI_Comm*>(handle.mpi_comm)); }
Comm::~Comm() = default;
Comm::Comm(Comm&&) noexcept = default;
Comm& Comm::operator=(Comm&&) noexcept = default;

Rank Comm::rank() const noexcept { return Rank{impl_->rank}; }
int Comm::size() const noexcept { return impl_->size; }
std::int64_t Comm::bytes_sent() const noexcept { return impl_->bytes_sent; }
std::int64_t Comm::messages_sent() const noexcept { return impl_->messages_sent; }
std::int64_t Comm::collective_calls() const noexcept { return impl_->collective_calls; }
double Comm::communication_cpu() const noexcept { return impl_->communication_cpu; }

double wall_time() noexcept {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

double cpu_time() noexcept {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::int64_t peak_memory() noexcept {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

void release_freed_memory() noexcept {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace skein
