// PhaseLog: see the header. Lines go to standard output; errors are the only thing that goes to standard error.
#include "comm/phase_log.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>
#include <utility>

#include "base/text.hpp"

namespace skein {
namespace {

/// Collective. The names of all ranks, sorted, each once.
std::vector<std::string> union_of_names(const Comm& comm, const std::map<std::string, std::int64_t>& counts) {
  std::vector<char> mine;
  for (const auto& [name, n] : counts) {
    mine.insert(mine.end(), name.begin(), name.end());
    mine.push_back('\0');
  }
  const std::vector<char> all = comm.all_gather(mine);
  std::vector<std::string> names;
  for (auto from = all.begin(); from != all.end();) {
    const auto to = std::find(from, all.end(), '\0');
    names.emplace_back(from, to);
    from = to + 1;
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

struct Spread {
  double min, mean, max;
};
Spread spread(const Comm& comm, double v) { return {comm.min(v), comm.sum(v) / comm.size(), comm.max(v)}; }

/// What an observer says against going on; empty: nothing.
template <class Ask>
std::string objection(const std::string& phase, Ask&& ask) {
  try {
    return ask() ? "" : fmt::format("cancelled by the caller in phase '{}'", phase);
  } catch (const std::exception& e) {
    return fmt::format("the caller's progress function has failed in phase '{}': {}", phase, e.what());
  } catch (...) {
    return fmt::format("the caller's progress function has failed in phase '{}'", phase);
  }
}

}  // namespace

/// A thread that wakes up now and then; it calls no MPI.
class PhaseLog::Heartbeat {
 public:
  Heartbeat(double seconds, double log_begin) : seconds_(seconds), log_begin_(log_begin), thread_([this] { run(); }) {}
  ~Heartbeat() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// A phase has begun; an empty name: it has ended. `tets`: how many there were at the end of the last one.
  void set(const std::string& phase, std::int64_t tets, std::int64_t expected) {
    {
      const std::lock_guard lock(mutex_);
      phase_ = phase, tets_ = tets, expected_ = expected, begin_ = wall_time();
    }
    wake_.notify_one();
  }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    while (!ending_) {
      const auto woken = wake_.wait_for(lock, std::chrono::duration<double>(seconds_));
      if (woken == std::cv_status::no_timeout || ending_ || phase_.empty()) continue;
      const double now = wall_time();
      std::string line = fmt::format("[{:8.1f} s]  {:<19} for {:.0f} s", now - log_begin_, phase_, now - begin_);
      if (tets_ > 0) line += fmt::format("; {} tets at its beginning", grouped(tets_));
      if (expected_ > 0) line += fmt::format(", {} expected in the end", grouped(expected_));
      fmt::print("{}\n", line);
      std::fflush(stdout);
    }
  }

  const double seconds_, log_begin_;
  std::mutex mutex_;  // of what follows
  std::condition_variable wake_;
  bool ending_ = false;
  std::string phase_;
  std::int64_t tets_ = 0, expected_ = 0;
  double begin_ = 0;
  std::thread thread_;
};

PhaseLog::PhaseLog(const Comm& comm, Output output) : comm_(&comm), output_(output), begin_(wall_time()) {}

PhaseLog::PhaseLog(const Comm& comm, PhaseObserver observer)
    : comm_(&comm), output_(Output::kQuiet), observer_(std::move(observer)), begin_(wall_time()) {}

PhaseLog::~PhaseLog() = default;

void PhaseLog::beat_every(double seconds) {
  if (output_ == Output::kQuiet || !comm_->is_root()) return;
  heartbeat_ = std::make_unique<Heartbeat>(seconds, begin_);
}

void PhaseLog::expect(std::int64_t tets) { expected_ = tets; }

double PhaseLog::elapsed() const noexcept { return wall_time() - begin_; }

void PhaseLog::start(const std::string& name) {
  name_ = name;
  if (observer_.started) objection_ = objection(name, [&] { return observer_.started(name); });
  busy_ = -1;
  counts_.clear();
  bytes_ = comm_->bytes_sent();
  messages_ = comm_->messages_sent();
  collectives_ = comm_->collective_calls();
  comm_cpu_ = comm_->communication_cpu();
  cpu_ = cpu_time();
  start_ = wall_time();
  if (heartbeat_) heartbeat_->set(name, phases_.empty() ? 0 : phases_.back().elements, expected_);
  if (output_ == Output::kTerminal && comm_->is_root()) {
    fmt::print("[{:8.1f} s]  {:<19} ...", elapsed(), name);
    std::fflush(stdout);
  }
}

void PhaseLog::count(const std::string& operation, std::int64_t n) { counts_[operation] += n; }

void PhaseLog::busy(double seconds) { busy_ = std::max(busy_, 0.0) + seconds; }

PhaseCost PhaseLog::cost_now(std::int64_t local_tets) const {
  const double seconds = wall_time() - start_;
  const double busy = busy_ < 0 ? seconds : busy_;
  // all of these before the log's own messages
  const double comm_cpu = comm_->communication_cpu() - comm_cpu_;
  const double cpu = std::max(0.0, cpu_time() - cpu_ - comm_cpu);
  const std::int64_t bytes = comm_->bytes_sent() - bytes_;
  const std::int64_t messages = comm_->messages_sent() - messages_;
  const std::int64_t collectives = comm_->collective_calls() - collectives_;

  PhaseCost cost;
  cost.name = name_;
  const Spread wall = spread(*comm_, seconds), work = spread(*comm_, busy);
  cost.seconds_min = wall.min, cost.seconds_mean = wall.mean, cost.seconds_max = wall.max;
  cost.busy_min = work.min, cost.busy_mean = work.mean, cost.busy_max = work.max;
  cost.balance = work.max > 0 ? 100 * work.mean / work.max : 100;
  const Spread used = spread(*comm_, cpu), waited = spread(*comm_, comm_cpu);
  cost.cpu_min = used.min, cost.cpu_mean = used.mean, cost.cpu_max = used.max;
  cost.comm_cpu_min = waited.min, cost.comm_cpu_mean = waited.mean, cost.comm_cpu_max = waited.max;
  cost.elements = comm_->sum(local_tets), cost.elements_max = comm_->max(local_tets);
  cost.bytes_sent = comm_->sum(bytes), cost.bytes_sent_max = comm_->max(bytes);
  cost.messages_sent = comm_->sum(messages), cost.messages_sent_max = comm_->max(messages);
  cost.collectives = comm_->max(collectives);
  cost.operations = all_counts();
  return cost;
}

std::map<std::string, std::int64_t> PhaseLog::all_counts() const {
  const std::vector<std::string> names = union_of_names(*comm_, counts_);
  std::vector<std::int64_t> numbers;
  for (const std::string& name : names) {
    const auto at = counts_.find(name);
    numbers.push_back(at == counts_.end() ? 0 : at->second);
  }
  comm_->reduce(std::span<std::int64_t>(numbers), Op::kSum);
  std::map<std::string, std::int64_t> out;
  for (std::size_t i = 0; i < names.size(); ++i) out[names[i]] = numbers[i];
  return out;
}

void PhaseLog::print(const PhaseCost& cost) const {
  if (output_ == Output::kQuiet || !comm_->is_root()) return;
  fmt::print("{}[{:8.1f} s]  {:<19} {:>15} tets {:9.2f} s  load balance {:3.0f} %{}\n",
             output_ == Output::kTerminal ? "\r" : "", elapsed(), cost.name, grouped(cost.elements), cost.seconds_max,
             cost.balance, output_ == Output::kTerminal ? "\033[K" : "");
  std::fflush(stdout);
}

void PhaseLog::ask_observer(const PhaseCost& cost) {
  if (!observer_.finished) return;
  agree(*comm_, [&] {
    const std::string now = objection(cost.name, [&] { return observer_.finished(cost); });
    const std::string& first = objection_.empty() ? now : objection_;
    if (!first.empty()) throw Error(ExitCode::kCancelled, first);
  });
}

void PhaseLog::finish(std::int64_t local_tets) {
  if (heartbeat_) heartbeat_->set("", 0, expected_);
  PhaseCost cost = cost_now(local_tets);
  print(cost);
  phases_.push_back(std::move(cost));
  name_.clear();
  release_freed_memory();  // the next phase has other arrays
  ask_observer(phases_.back());
}

void PhaseLog::note(const std::string& line) {
  if (observer_.noted) observer_.noted(line);
  if (output_ == Output::kQuiet || !comm_->is_root()) return;
  // in the middle of a phase the "running" line gives way; its finished line comes later anyway
  fmt::print("{}{}\n", output_ == Output::kTerminal && !name_.empty() ? "\r\033[K" : "", line);
  std::fflush(stdout);
}

}  // namespace skein
