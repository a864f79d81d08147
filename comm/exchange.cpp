// Sparse exchange on bytes: who sends how much (announce), then the blocks themselves (deliver).
#include "comm/exchange.hpp"

#include <cstring>
#include <thread>

#include "comm/impl.hpp"

namespace skein::detail {
namespace {

struct Requests {
  std::vector<MPI_Request> list;
  MPI_Request* add() { return &list.emplace_back(MPI_REQUEST_NULL); }
  void wait() { MPI_Waitall(static_cast<int>(list.size()), list.data(), MPI_STATUSES_IGNORE); }
};

/// Takes one announcement if there is one.
bool take_announcement(const Comm::Impl& impl, int tag, std::vector<Announced>& got) {
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, tag, impl.mpi, &there, &status);
  if (there == 0) return false;
  std::uint64_t bytes = 0;
  MPI_Recv(&bytes, sizeof bytes, MPI_BYTE, status.MPI_SOURCE, tag, impl.mpi, MPI_STATUS_IGNORE);
  got.push_back({Rank{status.MPI_SOURCE}, bytes});
  return true;
}

}  // namespace

// Non-blocking consensus [HoeflerSiebertLumsdaine2010]: a synchronous send completes when its receiver has taken
// it; who has seen all his own complete enters a non-blocking barrier and goes on receiving; the barrier completes when
// everything has arrived everywhere. No array of length P, and no MPI topology (creating one can hang in Open MPI 4.1).
// A rank may be one announcement ahead of another, never two, so two tags in turn keep them apart.
std::vector<Announced> announce(const Comm& comm, std::span<const SendBlock> send) {
  const auto& impl = comm.impl();
  const CpuMeter meter(comm);
  const int tag = kTagAnnounce + static_cast<int>(impl.announcements++ % 2);
  std::vector<Announced> got;
  std::vector<std::uint64_t> bytes;
  bytes.reserve(send.size());
  Requests sends;
  sends.list.reserve(send.size());
  for (const auto& s : send) {
    if (s.bytes == 0) continue;
    if (s.rank == comm.rank()) {
      got.push_back({s.rank, s.bytes});
      continue;
    }
    bytes.push_back(s.bytes);
    MPI_Issend(&bytes.back(), sizeof(std::uint64_t), MPI_BYTE, num(s.rank), tag, impl.mpi, sends.add());
  }
  impl.bytes_sent += static_cast<std::int64_t>(bytes.size() * sizeof(std::uint64_t));
  impl.messages_sent += static_cast<std::int64_t>(bytes.size());
  if (impl.size == 1) return got;
  ++impl.collective_calls;  // the barrier
  MPI_Request barrier = MPI_REQUEST_NULL;
  bool in_barrier = false;
  for (int done = 0;;) {
    if (take_announcement(impl, tag, got)) continue;
    if (in_barrier) {
      MPI_Test(&barrier, &done, MPI_STATUS_IGNORE);
      if (done != 0) break;
    } else {
      MPI_Testall(static_cast<int>(sends.list.size()), sends.list.data(), &done, MPI_STATUSES_IGNORE);
      if (done != 0) {
        MPI_Ibarrier(impl.mpi, &barrier);
        in_barrier = true;
      }
    }
    std::this_thread::yield();
  }
  std::sort(got.begin(), got.end(), [](const Announced& a, const Announced& b) { return a.rank < b.rank; });
  return got;
}

void deliver(const Comm& comm, std::span<const SendBlock> send, std::span<const RecvBlock> recv) {
  const auto& impl = comm.impl();
  const CpuMeter meter(comm);
  const void* own = nullptr;
  Requests requests;
  for (const auto& r : recv) {
    if (r.rank == comm.rank()) continue;
    for_chunks(r.bytes, [&](std::size_t at, int n) {
      MPI_Irecv(static_cast<std::byte*>(r.data) + at, n, MPI_BYTE, num(r.rank), kTagBlock, impl.mpi, requests.add());
    });
  }
  for (const auto& s : send) {
    if (s.rank == comm.rank()) {
      own = s.data;
      continue;
    }
    impl.bytes_sent += static_cast<std::int64_t>(s.bytes);
    for_chunks(s.bytes, [&](std::size_t at, int n) {
      ++impl.messages_sent;
      MPI_Isend(static_cast<const std::byte*>(s.data) + at, n, MPI_BYTE, num(s.rank), kTagBlock, impl.mpi,
                requests.add());
    });
  }
  for (const auto& r : recv) {
    if (r.rank == comm.rank() && r.bytes > 0) std::memcpy(r.data, own, r.bytes);
  }
  requests.wait();
}

}  // namespace skein::detail
