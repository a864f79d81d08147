// Work for a few threads at once.
#pragma once
#include <omp.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <tuple>
#include <utility>
#include <vector>

namespace skein {

/// Calls work(w) once for each w = 0 .. threads-1 in an OpenMP parallel region; the first exception (by w) is thrown
/// again when all have ended. OpenMP may give fewer threads than asked (OMP_DYNAMIC, OMP_THREAD_LIMIT, a region inside
/// another): each of them then takes several w, so the result is the same. The calling thread does w = 0.
/// @pre work(w) does not wait for another w.
template <class Work>
void in_parallel(int threads, Work&& work) {
  std::vector<std::exception_ptr> failed(static_cast<std::size_t>(threads));
  const auto guarded = [&](int w) noexcept {
    try {
      work(w);
    } catch (...) {
      failed[w] = std::current_exception();
    }
  };
  if (threads == 1) {
    guarded(0);
  } else {
#pragma omp parallel num_threads(threads)
    {
      const int there = omp_get_num_threads();
      for (int w = omp_get_thread_num(); w < threads; w += there) guarded(w);
    }
  }
  for (const auto& e : failed) {
    if (e) std::rethrow_exception(e);
  }
}

/// Where share w of n items begins when `threads` threads have as many each; share_begin(n, threads, threads) is n.
constexpr std::size_t share_begin(std::size_t n, int w, int threads) noexcept {
  return n * static_cast<std::size_t>(w) / static_cast<std::size_t>(threads);
}

/// How many of these threads are worth starting for n short loops.
constexpr int threads_for(std::size_t n, int threads) noexcept {
  constexpr std::size_t kEnough = 8192;  // about what starting a thread takes
  return n / kEnough >= static_cast<std::size_t>(threads) ? threads : std::max(1, static_cast<int>(n / kEnough));
}

/// Grows some vectors to so many items each (n[i]: of the i-th); longer ones stay as they are. A page of memory costs
/// more when it is touched for the first time than when it is filled, so the threads touch them all first, then each
/// clears whole vectors.
template <class... T>
void grow_in_parallel(int threads, std::tuple<std::vector<T>&...> vectors,
                      std::array<std::size_t, sizeof...(T)> sizes) {
  constexpr std::size_t kPage = 4096;
  const auto touch = [](auto& v, std::size_t n, int w, int threads) {
    if (n <= v.size()) return;
    auto* const begin = reinterpret_cast<volatile char*>(v.data() + v.size());
    const std::size_t bytes = (n - v.size()) * sizeof(v[0]);
    for (std::size_t i = share_begin(bytes, w, threads); i < share_begin(bytes, w + 1, threads); i += kPage)
      begin[i] = 0;
  };
  const auto for_each = [&](auto&& f) {  // f(vector, size)
    std::size_t i = 0;
    std::apply([&](auto&... v) { (f(v, sizes[i++]), ...); }, vectors);
  };
  for_each([](auto& v, std::size_t n) { v.reserve(n); });
  in_parallel(threads, [&](int w) { for_each([&](auto& v, std::size_t n) { touch(v, n, w, threads); }); });
  const int at_once = std::min(threads, static_cast<int>(sizeof...(T)));
  in_parallel(at_once, [&](int w) {
    int at = 0;
    for_each([&](auto& v, std::size_t n) {
      if (at++ % at_once == w && n > v.size()) v.resize(n);
    });
  });
}
/// The same, to n items each.
template <class... T>
void grow_in_parallel(int threads, std::tuple<std::vector<T>&...> vectors, std::size_t n) {
  std::array<std::size_t, sizeof...(T)> sizes;
  sizes.fill(n);
  grow_in_parallel(threads, vectors, sizes);
}

template <class T>
void grow_in_parallel(std::vector<T>& v, std::size_t n, int threads) {
  grow_in_parallel(threads, std::tie(v), n);
}

}  // namespace skein
