// Templates of comm.hpp, brought down to bytes and number types.
#pragma once
#include "comm/comm.hpp"

namespace skein {
namespace detail {

enum class Number { kDouble, kInt32, kInt64, kUint64 };
template <Reducible T>
constexpr Number number_type() noexcept {
  if constexpr (std::is_same_v<T, double>) return Number::kDouble;
  if constexpr (std::is_same_v<T, std::int32_t>) return Number::kInt32;
  if constexpr (std::is_same_v<T, std::int64_t>) return Number::kInt64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return Number::kUint64;
}

// All collective; sizes in bytes.
void reduce(const Comm& comm, void* values, std::size_t n, Number type, Op op);
/// `bytes` from every rank into out[bytes * size].
void all_gather_fixed(const Comm& comm, const void* in, std::size_t bytes, void* out);
/// Blocks of different size; bytes[r] is that of rank r. `out` holds all of them.
void all_gather_blocks(const Comm& comm, const void* in, std::span<const std::int64_t> bytes, void* out);
/// The same on rank 0 only; `out` is not used elsewhere.
void gather_blocks(const Comm& comm, const void* in, std::span<const std::int64_t> bytes, void* out);
void broadcast_bytes(const Comm& comm, void* data, std::size_t bytes, Rank root);

/// The sizes of the ranks' blocks in bytes, and their sum in items.
template <Sendable T>
std::vector<std::int64_t> block_bytes(const Comm& comm, std::size_t items) {
  const auto mine = static_cast<std::int64_t>(items * sizeof(T));
  std::vector<std::int64_t> bytes(static_cast<std::size_t>(comm.size()));
  all_gather_fixed(comm, &mine, sizeof mine, bytes.data());
  return bytes;
}
template <Sendable T>
std::size_t total_items(std::span<const std::int64_t> bytes) {
  std::size_t all = 0;
  for (const auto b : bytes) all += static_cast<std::size_t>(b);
  return all / sizeof(T);
}

}  // namespace detail

template <Reducible T>
void Comm::reduce(std::span<T> v, Op op) const {
  detail::reduce(*this, v.data(), v.size(), detail::number_type<T>(), op);
}

template <Reducible T>
T Comm::reduce(T v, Op op) const {
  detail::reduce(*this, &v, 1, detail::number_type<T>(), op);
  return v;
}

template <Reducible T>
T Comm::exclusive_sum(T v) const {
  const std::vector<T> all = all_gather(v);
  T sum = 0;
  for (std::size_t r = 0; r < idx(rank()); ++r) sum += all[r];
  return sum;
}

template <Sendable T>
std::vector<T> Comm::all_gather(const T& v) const {
  std::vector<T> out(static_cast<std::size_t>(size()));
  detail::all_gather_fixed(*this, &v, sizeof(T), out.data());
  return out;
}

template <Sendable T>
std::vector<T> Comm::all_gather(const std::vector<T>& v) const {
  const auto bytes = detail::block_bytes<T>(*this, v.size());
  std::vector<T> out(detail::total_items<T>(bytes));
  detail::all_gather_blocks(*this, v.data(), bytes, out.data());
  return out;
}

template <Sendable T>
std::vector<T> Comm::gather(const std::vector<T>& v) const {
  const auto bytes = detail::block_bytes<T>(*this, v.size());
  std::vector<T> out(is_root() ? detail::total_items<T>(bytes) : 0);
  detail::gather_blocks(*this, v.data(), bytes, out.data());
  return out;
}

template <Sendable T>
T Comm::broadcast(const T& v) const {
  T out = v;
  detail::broadcast_bytes(*this, &out, sizeof(T), Rank{0});
  return out;
}

}  // namespace skein
