// run_as_guest(): duplicates, and how ranks end together.
#include "comm/guest.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "comm/impl.hpp"
#include "comm/verdict.hpp"

namespace skein {
namespace {

MPI_Comm checked(MpiHandle caller) {
  int started = 0, finished = 0, between = 0;
  MPI_Initialized(&started);
  MPI_Finalized(&finished);
  if (started == 0 || finished != 0) throw Error(ExitCode::kUsage, "MPI is not running; Skein leaves it to the caller");
  const MPI_Comm comm = *static_cast<const MPI_Comm*>(caller.mpi_comm);
  if (comm == MPI_COMM_NULL) throw Error(ExitCode::kUsage, "the communicator is MPI_COMM_NULL");
  MPI_Comm_test_inter(comm, &between);
  if (between != 0) throw Error(ExitCode::kUsage, "the communicator is an inter-communicator; give one of one group");
  return comm;
}

/// The caller's ranks twice: to work on, and to meet on after work that was broken off, free of its messages.
class Duplicates {
 public:
  explicit Duplicates(MPI_Comm from) : work_(detail::duplicate(from)), farewell_(detail::duplicate(from)) {}
  ~Duplicates() {
    for (Comm* c : {&work_, &farewell_}) {
      if (abandoned_) detail::abandon(*c);
    }
  }
  Duplicates(const Duplicates&) = delete;
  Duplicates& operator=(const Duplicates&) = delete;
  [[nodiscard]] const Comm& work() const noexcept { return work_; }
  [[nodiscard]] const Comm& farewell() const noexcept { return farewell_; }
  /// Messages are still on their way: nothing is freed.
  void abandon() noexcept { abandoned_ = true; }

 private:
  Comm work_, farewell_;
  bool abandoned_ = false;
};

/// Waits until all ranks have called it; not longer than `patience` seconds if that is not negative. Tells whether they
/// have.
bool meet(const Comm& comm, double patience) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(comm.impl().mpi, &request);
  if (patience < 0) return MPI_Wait(&request, MPI_STATUS_IGNORE) == MPI_SUCCESS;
  for (const double begin = wall_time(); wall_time() - begin < patience;) {
    int all = 0;
    MPI_Test(&request, &all, MPI_STATUS_IGNORE);
    if (all != 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace

void run_as_guest(MpiHandle caller, const std::function<void(const Comm&)>& work, double patience) {
  Duplicates ranks(checked(caller));
  const Verdict mine = verdict_of(ranks.work(), [&] { work(ranks.work()); });
  const bool perhaps_alone = mine.code != ExitCode::kOk && !mine.agreed;
  if (!meet(ranks.farewell(), perhaps_alone ? patience : -1)) {
    ranks.abandon();
    throw Error(ExitCode::kAlone, fmt::format("{} (on this rank alone, {} of {}; the others may wait for it for ever)",
                                              mine.line, num(ranks.work().rank()), ranks.work().size()));
  }
  agree_on(ranks.farewell(), mine);
}

}  // namespace skein
