// PhaseLog: progress lines, one per phase, and the cost of each phase for the report.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "comm/comm.hpp"

namespace skein {

/// What one phase cost, over all ranks.
struct PhaseCost {
  std::string name;
  double seconds_min = 0, seconds_mean = 0, seconds_max = 0;  ///< wall time between start and finish on each rank
  double busy_min = 0, busy_mean = 0, busy_max = 0;           ///< of this, useful local work (see PhaseLog::busy)
  double balance = 100;                                       ///< 100 * mean / max of busy, per cent
  /// CPU seconds of each rank outside communication and waiting. On cores that several ranks share, these measure the
  /// work of a rank; wall times do not.
  double cpu_min = 0, cpu_mean = 0, cpu_max = 0;
  double comm_cpu_min = 0, comm_cpu_mean = 0, comm_cpu_max = 0;  ///< CPU seconds inside communication
  std::int64_t elements = 0, elements_max = 0;                   ///< tetrahedra at its end: all, of the largest part
  std::int64_t bytes_sent = 0, bytes_sent_max = 0;               ///< over all ranks; of the rank with most
  std::int64_t messages_sent = 0, messages_sent_max = 0;         ///< to single ranks; the same
  std::int64_t collectives = 0;                                  ///< collective calls, the same on every rank
  std::map<std::string, std::int64_t> operations;                ///< over all ranks, e.g. "insert": 1234
};

/// Somebody other than a reader of standard output who wants to know. All functions are called on every rank; none of
/// them may be empty.
struct PhaseObserver {
  std::function<bool(const std::string& phase)> started;  ///< false: stop at the end of this phase
  std::function<bool(const PhaseCost& cost)> finished;    ///< false: stop now
  std::function<void(const std::string& line)> noted;
};

class PhaseLog {
 public:
  enum class Output { kTerminal, kPlain, kQuiet };
  PhaseLog(const Comm& comm, Output output);
  /// Prints nothing, but tells the observer. When that wants to stop on any rank, finish() throws Error(kCancelled) on
  /// all of them; when it throws an exception itself, that one's text.
  PhaseLog(const Comm& comm, PhaseObserver observer);
  ~PhaseLog();
  PhaseLog(const PhaseLog&) = delete;
  PhaseLog& operator=(const PhaseLog&) = delete;

  /// From now on, while a phase takes long, a line every so many seconds on rank 0 says so (none when quiet). Not
  /// collective.
  void beat_every(double seconds);
  /// What the run is expected to come to, for those lines. Not collective.
  void expect(std::int64_t tets);

  /// Starts a phase; the one before must be finished. Not collective.
  void start(const std::string& name);
  /// Operations that this rank has done in the current phase; adds up. Not collective.
  void count(const std::string& operation, std::int64_t n);
  /// Seconds of useful local work in the current phase (without waiting for others); adds up. Without a call, the
  /// whole time up to finish() counts. Not collective.
  void busy(double seconds);
  /// Collective. Ends the phase and prints its line on rank 0: elapsed time since the log began, name, tetrahedra over
  /// all ranks, seconds, balance in %.
  void finish(std::int64_t local_tets);
  /// A line of text on rank 0 (none when quiet), or for the observer. Not collective.
  void note(const std::string& line);

  [[nodiscard]] const std::vector<PhaseCost>& phases() const noexcept { return phases_; }
  [[nodiscard]] double elapsed() const noexcept;

 private:
  [[nodiscard]] PhaseCost cost_now(std::int64_t local_tets) const;
  [[nodiscard]] std::map<std::string, std::int64_t> all_counts() const;
  void print(const PhaseCost& cost) const;
  void ask_observer(const PhaseCost& cost);
  class Heartbeat;
  const Comm* comm_;
  Output output_;
  PhaseObserver observer_;
  std::string objection_;  ///< of the observer, when the phase started
  double begin_ = 0, start_ = 0, busy_ = -1;
  double cpu_ = 0, comm_cpu_ = 0;  // these and the next when the phase started
  std::int64_t bytes_ = 0, messages_ = 0, collectives_ = 0;
  std::string name_;
  std::map<std::string, std::int64_t> counts_;
  std::vector<PhaseCost> phases_;
  std::int64_t expected_ = 0;
  std::unique_ptr<Heartbeat> heartbeat_;
};

}  // namespace skein
