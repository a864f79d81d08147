// What Comm hides: the MPI communicator. Included by the .cpp files of comm/ only.
#pragma once
#include <mpi.h>

#include "comm/comm.hpp"

namespace skein {

struct Comm::Impl {
  MPI_Comm mpi = MPI_COMM_NULL;
  int rank = 0;
  int size = 1;
  mutable std::int64_t bytes_sent = 0;
  mutable std::int64_t messages_sent = 0;
  mutable std::int64_t collective_calls = 0;
  mutable double communication_cpu = 0;
  mutable unsigned announcements = 0;  ///< number of calls of announce(): consecutive ones use different tags
};

namespace detail {

/// Collective over `from`. The same ranks with a communicator of their own.
Comm duplicate(MPI_Comm from);
/// From now on the communicator is nobody's: it is not freed, since messages may still be on their way in it.
void abandon(Comm& comm) noexcept;

/// MPI counts are ints: longer messages go in chunks of this many bytes.
inline constexpr std::size_t kChunk = std::size_t{1} << 30;

enum Tag : int { kTagReduce = 1, kTagGather = 2, kTagBlock = 3, kTagAnnounce = 4 /* and 5 */ };

/// CPU time during the life of this object counts as communication. MPI polls while it waits, which would look like
/// work otherwise.
class CpuMeter {
 public:
  explicit CpuMeter(const Comm& comm) noexcept : impl_(comm.impl()), begin_(cpu_time()) {}
  ~CpuMeter() { impl_.communication_cpu += cpu_time() - begin_; }
  CpuMeter(const CpuMeter&) = delete;
  CpuMeter& operator=(const CpuMeter&) = delete;

 private:
  const Comm::Impl& impl_;
  double begin_;
};

/// Calls send(first byte, bytes as int) for each chunk.
template <class F>
void for_chunks(std::size_t bytes, F f) {
  for (std::size_t at = 0; at < bytes; at += kChunk) f(at, static_cast<int>(bytes - at < kChunk ? bytes - at : kChunk));
}

}  // namespace detail
}  // namespace skein
