// The collectives of Comm on bytes and number types.
#include <algorithm>
#include <bit>
#include <cstring>

#include "comm/impl.hpp"

namespace skein {
namespace detail {
namespace {

MPI_Op mpi_op(Op op) noexcept {
  switch (op) {
    case Op::kSum:
      return MPI_SUM;
    case Op::kMin:
      return MPI_MIN;
    case Op::kMax:
      return MPI_MAX;
  }
  return MPI_OP_NULL;
}

MPI_Datatype mpi_type(Number type) noexcept {
  switch (type) {
    case Number::kDouble:
      return MPI_DOUBLE;
    case Number::kInt32:
      return MPI_INT32_T;
    case Number::kInt64:
      return MPI_INT64_T;
    case Number::kUint64:
      return MPI_UINT64_T;
  }
  return MPI_DATATYPE_NULL;
}

void count_bytes(const Comm& comm, std::size_t bytes) noexcept {
  if (comm.size() > 1) comm.impl().bytes_sent += static_cast<std::int64_t>(bytes);
}

/// One collective call; as long as it lives, CPU time counts as communication.
class Collective {
 public:
  explicit Collective(const Comm& comm) noexcept : meter_(comm) {
    if (comm.size() > 1) ++comm.impl().collective_calls;
  }

 private:
  CpuMeter meter_;
};

/// low = low op high, element by element.
void fold(double* low, const double* high, std::size_t n, Op op) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    if (op == Op::kSum) low[i] += high[i];
    if (op == Op::kMin) low[i] = high[i] < low[i] ? high[i] : low[i];
    if (op == Op::kMax) low[i] = low[i] < high[i] ? high[i] : low[i];
  }
}

/// Recursive doubling with a fixed tree. MPI_Allreduce may choose its order by message size, and need not give the same
/// bits on every rank; here both partners fold (lower ranks, higher ranks) in this order, so they get the same bits,
/// and so does every run. Ranks beyond the largest power of two hand their values to a partner and get the result.
void reduce_doubles(const Comm& comm, double* v, int n, Op op) {
  const auto& impl = comm.impl();
  const int paired = static_cast<int>(std::bit_floor(static_cast<unsigned>(impl.size)));
  const auto count = static_cast<std::size_t>(n);
  std::vector<double> other(count);
  if (impl.rank >= paired) {
    MPI_Send(v, n, MPI_DOUBLE, impl.rank - paired, kTagReduce, impl.mpi);
    MPI_Recv(v, n, MPI_DOUBLE, impl.rank - paired, kTagReduce, impl.mpi, MPI_STATUS_IGNORE);
    return;
  }
  const bool has_extra = impl.rank + paired < impl.size;
  if (has_extra) {
    MPI_Recv(other.data(), n, MPI_DOUBLE, impl.rank + paired, kTagReduce, impl.mpi, MPI_STATUS_IGNORE);
    fold(v, other.data(), count, op);
  }
  for (int bit = 1; bit < paired; bit *= 2) {
    const int partner = impl.rank ^ bit;
    MPI_Sendrecv(v, n, MPI_DOUBLE, partner, kTagReduce, other.data(), n, MPI_DOUBLE, partner, kTagReduce, impl.mpi,
                 MPI_STATUS_IGNORE);
    if (partner < impl.rank) std::swap_ranges(v, v + n, other.begin());
    fold(v, other.data(), count, op);
  }
  if (has_extra) MPI_Send(v, n, MPI_DOUBLE, impl.rank + paired, kTagReduce, impl.mpi);
}

std::vector<std::size_t> block_offsets(std::span<const std::int64_t> bytes) {
  std::vector<std::size_t> offset{0};
  offset.reserve(bytes.size() + 1);
  for (const auto b : bytes) offset.push_back(offset.back() + static_cast<std::size_t>(b));
  return offset;
}

}  // namespace

void reduce(const Comm& comm, void* values, std::size_t n, Number type, Op op) {
  if (comm.size() == 1) return;
  const Collective call(comm);
  constexpr std::size_t kMost = std::size_t{1} << 20;  // numbers at a time
  const std::size_t item = type == Number::kInt32 ? 4 : 8;
  count_bytes(comm, n * item);
  for (std::size_t at = 0; at < n; at += kMost) {
    const auto count = static_cast<int>(std::min(kMost, n - at));
    void* v = static_cast<std::byte*>(values) + at * item;
    if (type == Number::kDouble) {
      reduce_doubles(comm, static_cast<double*>(v), count, op);
    } else {
      MPI_Allreduce(MPI_IN_PLACE, v, count, mpi_type(type), mpi_op(op), comm.impl().mpi);
    }
  }
}

void all_gather_fixed(const Comm& comm, const void* in, std::size_t bytes, void* out) {
  const Collective call(comm);
  count_bytes(comm, bytes);
  const auto n = static_cast<int>(bytes);
  MPI_Allgather(in, n, MPI_BYTE, out, n, MPI_BYTE, comm.impl().mpi);
}

void all_gather_blocks(const Comm& comm, const void* in, std::span<const std::int64_t> bytes, void* out) {
  const Collective call(comm);
  const auto offset = block_offsets(bytes);
  auto* to = static_cast<std::byte*>(out);
  const std::size_t self = idx(comm.rank());
  count_bytes(comm, offset[self + 1] - offset[self]);
  if (offset.back() <= kChunk) {
    std::vector<int> count(bytes.begin(), bytes.end()), first(offset.begin(), offset.end() - 1);
    MPI_Allgatherv(in, count[self], MPI_BYTE, to, count.data(), first.data(), MPI_BYTE, comm.impl().mpi);
    return;
  }
  std::memcpy(to + offset[self], in, offset[self + 1] - offset[self]);
  for (std::size_t r = 0; r < bytes.size(); ++r) {
    for_chunks(offset[r + 1] - offset[r], [&](std::size_t at, int n) {
      MPI_Bcast(to + offset[r] + at, n, MPI_BYTE, static_cast<int>(r), comm.impl().mpi);
    });
  }
}

void gather_blocks(const Comm& comm, const void* in, std::span<const std::int64_t> bytes, void* out) {
  const CpuMeter meter(comm);
  const auto& impl = comm.impl();
  const auto mine = static_cast<std::size_t>(bytes[idx(comm.rank())]);
  if (impl.rank != 0) {
    count_bytes(comm, mine);
    for_chunks(mine, [&](std::size_t at, int n) {
      ++impl.messages_sent;
      MPI_Send(static_cast<const std::byte*>(in) + at, n, MPI_BYTE, 0, kTagGather, impl.mpi);
    });
    return;
  }
  const auto offset = block_offsets(bytes);
  auto* to = static_cast<std::byte*>(out);
  if (mine > 0) std::memcpy(to, in, mine);
  for (int r = 1; r < impl.size; ++r) {
    const auto i = static_cast<std::size_t>(r);
    for_chunks(offset[i + 1] - offset[i], [&](std::size_t at, int n) {
      MPI_Recv(to + offset[i] + at, n, MPI_BYTE, r, kTagGather, impl.mpi, MPI_STATUS_IGNORE);
    });
  }
}

void broadcast_bytes(const Comm& comm, void* data, std::size_t bytes, Rank root) {
  const Collective call(comm);
  if (comm.rank() == root) count_bytes(comm, bytes);
  for_chunks(bytes, [&](std::size_t at, int n) {
    MPI_Bcast(static_cast<std::byte*>(data) + at, n, MPI_BYTE, num(root), comm.impl().mpi);
  });
}

}  // namespace detail

std::string Comm::broadcast(const std::string& s) const {
  std::string out(broadcast(static_cast<std::uint64_t>(s.size())), '\0');
  if (is_root()) out = s;
  detail::broadcast_bytes(*this, out.data(), out.size(), Rank{0});
  return out;
}

void Comm::barrier() const {
  const detail::Collective call(*this);
  MPI_Barrier(impl_->mpi);
}

}  // namespace skein
