// Comm: the ranks of a run and their typed collectives. Only comm/ names MPI; this header does not include it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.hpp"
#include "base/ids.hpp"
#include "comm/mpi_handle.hpp"

namespace skein {

/// Initialises MPI (thread level FUNNELED) and finalises it. One per program, in main(). Exceptions must be caught
/// inside its scope: an exception that leaves the scope ends all ranks at once (exit code 5), because the others may
/// wait for this one. A rank that fails alone must call abort_all() and not return from main(): MPI_Finalize would wait
/// for the others.
class Environment {
 public:
  Environment(int& argc, char**& argv);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
};

enum class Op { kSum, kMin, kMax };

/// Numbers that collectives can reduce.
template <class T>
concept Reducible = std::is_same_v<T, double> || std::is_same_v<T, std::int32_t> || std::is_same_v<T, std::int64_t> ||
    std::is_same_v<T, std::uint64_t>;
/// Values that can be sent as bytes.
template <class T>
concept Sendable = std::is_trivially_copyable_v<T>;

/// A group of ranks; owns its MPI communicator. Movable, not copyable.
class Comm {
 public:
  /// All ranks of the run. Collective.
  static Comm world();
  /// This process alone: a communicator of one rank.
  static Comm self();
  /// Collective over the caller's communicator: the same ranks, with a communicator of their own.
  static Comm from(MpiHandle caller);
  ~Comm();
  Comm(Comm&&) noexcept;
  Comm& operator=(Comm&&) noexcept;
  Comm(const Comm&) = delete;
  Comm& operator=(const Comm&) = delete;

  [[nodiscard]] Rank rank() const noexcept;
  [[nodiscard]] int size() const noexcept;
  [[nodiscard]] bool is_root() const noexcept { return rank() == Rank{0}; }

  /// Collective. The reduction over all ranks, the same bits on every rank.
  template <Reducible T>
  [[nodiscard]] T reduce(T v, Op op) const;
  template <Reducible T>
  [[nodiscard]] T sum(T v) const {
    return reduce(v, Op::kSum);
  }
  template <Reducible T>
  [[nodiscard]] T min(T v) const {
    return reduce(v, Op::kMin);
  }
  template <Reducible T>
  [[nodiscard]] T max(T v) const {
    return reduce(v, Op::kMax);
  }
  /// Collective. Element by element, in place.
  template <Reducible T>
  void reduce(std::span<T> v, Op op) const;
  /// Collective. The sum over all lower ranks (0 on rank 0).
  template <Reducible T>
  [[nodiscard]] T exclusive_sum(T v) const;
  /// Collective. One value per rank, by rank.
  template <Sendable T>
  [[nodiscard]] std::vector<T> all_gather(const T& v) const;
  /// Collective. The ranks' vectors one behind the other, by rank.
  template <Sendable T>
  [[nodiscard]] std::vector<T> all_gather(const std::vector<T>& v) const;
  /// Collective. The ranks' vectors one behind the other on rank 0; empty elsewhere.
  template <Sendable T>
  [[nodiscard]] std::vector<T> gather(const std::vector<T>& v) const;
  /// Collective. Rank 0's value on every rank.
  template <Sendable T>
  [[nodiscard]] T broadcast(const T& v) const;
  /// Collective. Rank 0's text on every rank.
  [[nodiscard]] std::string broadcast(const std::string& s) const;
  /// Collective.
  void barrier() const;

  /// Bytes that this rank has sent to others through this object so far. A collective counts as the bytes of this
  /// rank's contribution, once.
  [[nodiscard]] std::int64_t bytes_sent() const noexcept;
  /// Messages to single ranks that this rank has sent through this object so far; collectives are not among them.
  [[nodiscard]] std::int64_t messages_sent() const noexcept;
  /// Collective calls through this object so far. Each costs about log2(ranks) messages one after the other.
  [[nodiscard]] std::int64_t collective_calls() const noexcept;
  /// CPU seconds that this process has used inside the calls of this object: copying, and waiting for others.
  [[nodiscard]] double communication_cpu() const noexcept;

  struct Impl;
  [[nodiscard]] Impl& impl() const noexcept { return *impl_; }
  struct Freed {
    void operator()(Impl* impl) const noexcept;
  };
  explicit Comm(std::unique_ptr<Impl, Freed> impl) noexcept;  ///< for comm/ only

 private:
  std::unique_ptr<Impl, Freed> impl_;
};

/// Collective. Runs `work` on every rank; when it throws on any, every rank throws the same Error: that of the lowest
/// failing rank. `work` must not call a collective.
void agree(const Comm& comm, const std::function<void()>& work);

/// What agree() throws: an Error that all ranks have. After catching it, a program may call collectives and end
/// normally. Any other exception may be on one rank alone; then only abort_all() ends the run without a hang.
class AgreedError : public Error {
 public:
  using Error::Error;
};
/// Not collective. Ends all ranks of the run at once, with this exit code. The caller has printed why.
[[noreturn]] void abort_all(ExitCode code) noexcept;

/// Seconds since some fixed moment.
double wall_time() noexcept;
/// CPU seconds that this process has used (all its threads).
double cpu_time() noexcept;
/// Largest resident memory of this process so far, in bytes.
std::int64_t peak_memory() noexcept;
/// Collective. Bytes that each rank may still take: the free memory of its machine (or of its control group, if that
/// has a limit) over the ranks on that machine, the least of all ranks; the largest number where it is not known.
std::int64_t free_memory(const Comm& comm);
/// Returns memory that is free but still kept by the allocator to the system. Arrays of a few megabytes that are
/// allocated and freed leave gaps that no later array fits into. Takes about a millisecond, so call it at the end of a
/// phase.
void release_freed_memory() noexcept;

}  // namespace skein

#include "comm/comm_inl.hpp"
