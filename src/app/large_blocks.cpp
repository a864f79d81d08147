// Large arrays of the program come straight from the system, in large pages: operator new and delete of the process.
//
// A mesh is walked through by ids that lie far from each other, so with pages of 4 kB much of the time goes into
// finding pages, and each page costs again when it is first touched. And an allocator that keeps what is freed in its
// heap lets the process grow by what lies between (docs/adr/0018-memory-blocks.md). What is smaller goes to malloc.
#include "app/large_blocks.hpp"

#if defined(__linux__) && !defined(SKEIN_SANITIZED)
#include <malloc.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>

#include "base/hash.hpp"

namespace skein::app {
namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;  ///< bytes; of x86-64 and of most others
constexpr std::size_t kSmallPage = std::size_t{4} << 10;
constexpr std::size_t kLargeBlock = std::size_t{1} << 20;  ///< from here on
/// From here on in large pages: the last one that is touched is half empty, which adds up over many ranks' arrays.
constexpr std::size_t kWorthLargePages = std::size_t{8} << 20;

constexpr std::size_t rounded_up(std::size_t n, std::size_t unit) noexcept { return (n + unit - 1) / unit * unit; }

struct Span {
  char* begin = nullptr;
  std::size_t bytes = 0;
};

/// New memory that begins at a large page's border; nothing if there is none. Its last part stays in small pages, so
/// that it takes no more than was asked for.
Span map_span(std::size_t bytes) noexcept {
  const std::size_t with_slack = bytes + kLargePage;
  void* const raw = mmap(nullptr, with_slack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (raw == MAP_FAILED) return {};
  const auto address = reinterpret_cast<std::uintptr_t>(raw);
  const std::size_t before = rounded_up(address, kLargePage) - address;
  char* const begin = static_cast<char*>(raw) + before;
  if (before > 0) munmap(raw, before);
  munmap(begin + bytes, kLargePage - before);
  const std::size_t in_large_pages = bytes / kLargePage * kLargePage;
  if (bytes >= kWorthLargePages)
    madvise(begin, in_large_pages, MADV_HUGEPAGE);  // a wish; without it the span is as good
  return {begin, bytes};
}

/// Moves large pages to another place in the address space, which costs next to nothing; where that cannot be, new ones
/// take their place. False if there are none.
bool move_pages(char* from, char* to, std::size_t bytes) noexcept {
  if (mremap(from, bytes, bytes, MREMAP_MAYMOVE | MREMAP_FIXED, to) != MAP_FAILED) return true;
  if (bytes > kLargePage) {  // some of them have been moved before
    const std::size_t half = rounded_up(bytes / 2, kLargePage);
    const bool first = move_pages(from, to, half);
    return move_pages(from + half, to + half, bytes - half) && first;
  }
  munmap(from, bytes);
  return mmap(to, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) != MAP_FAILED;
}

/// The spans in use, by where they begin, in an open table with room for far more than a process has at a time.
class UsedSpans {
 public:
  [[nodiscard]] bool full() const noexcept { return used_ == kSlots / 2; }
  void insert(Span s) noexcept {
    std::size_t at = home(s.begin);
    while (slot_[at].begin != nullptr) at = next(at);
    slot_[at] = s, ++used_;
  }
  /// The span that begins at p, which is none of the table's any more; an empty one if it never was.
  Span take(void* p) noexcept {
    std::size_t at = home(p);
    for (; slot_[at].begin != p; at = next(at)) {
      if (slot_[at].begin == nullptr) return {};
    }
    const Span taken = slot_[at];
    --used_;
    for (std::size_t gap = at;; slot_[gap] = slot_[at], gap = at) {  // who was pushed on by a neighbour moves back
      slot_[gap] = {};
      do {
        at = next(at);
        if (slot_[at].begin == nullptr) return taken;
      } while (distance(home(slot_[at].begin), at) < distance(gap, at));
    }
  }

 private:
  static constexpr std::size_t kSlots = 4096;
  static std::size_t home(void* p) noexcept {
    return mix(reinterpret_cast<std::uintptr_t>(p) / kLargePage) & (kSlots - 1);
  }
  static std::size_t next(std::size_t at) noexcept { return (at + 1) & (kSlots - 1); }
  static std::size_t distance(std::size_t from, std::size_t to) noexcept { return (to - from) & (kSlots - 1); }

  std::size_t used_ = 0;
  std::array<Span, kSlots> slot_{};
};

/// All large blocks of the process. Touching new memory costs far more than using old memory again, and arrays of like
/// sizes come and go with every step. So what is freed is kept for the next block, up to an eighth of the most that was
/// ever in use, and as long as both together stay within that most. Where no spare block is large enough, pages of
/// several are moved together.
class LargeBlocks {
 public:
  /// nullptr if there is no room for it.
  void* allocate(std::size_t size) noexcept {
    const std::lock_guard hold(guard_);
    if (used_.full()) return nullptr;
    const std::size_t bytes = rounded_up(size, kSmallPage);
    Span s = from_spare(bytes);
    if (s.begin == nullptr) {
      while (n_spare_ > 0 && in_use_ + bytes + spare_ > most_) drop_spare(0);
      s = map_span(bytes);
      if (s.begin != nullptr && !fill_from_spares(s)) {
        munmap(s.begin, s.bytes);
        s = {};
      }
    }
    if (s.begin == nullptr) return nullptr;
    in_use_ += s.bytes, most_ = std::max(most_, in_use_);
    used_.insert(s);
    return s.begin;
  }
  /// Tells whether p was one of them.
  bool release(void* p) noexcept {
    const std::lock_guard hold(guard_);
    const Span s = used_.take(p);
    if (s.begin == nullptr) return false;
    in_use_ -= s.bytes;
    keep(s);
    return true;
  }
  void give_back_spares() noexcept {
    const std::lock_guard hold(guard_);
    while (n_spare_ > 0) drop_spare(n_spare_ - 1);
  }

 private:
  /// The smallest spare span that is large enough; what it has too much stays spare.
  Span from_spare(std::size_t bytes) noexcept {
    std::size_t best = n_spare_;
    for (std::size_t i = 0; i < n_spare_; ++i) {
      if (spares_[i].bytes >= bytes && (best == n_spare_ || spares_[i].bytes < spares_[best].bytes)) best = i;
    }
    if (best == n_spare_) return {};
    Span s = spares_[best];
    remove_spare(best);
    const std::size_t own = rounded_up(bytes, kLargePage);
    if (s.bytes >= own + kLargeBlock) {
      keep({s.begin + own, s.bytes - own});
      s.bytes = own;
    }
    return s;
  }
  /// Gives the first part of a new span, which is used in any case, the pages of spare ones.
  bool fill_from_spares(Span s) noexcept {
    const std::size_t most = s.bytes / 3 * 2;
    for (std::size_t filled = 0; n_spare_ > 0 && most - filled >= kLargePage;) {
      const Span spare = spares_[n_spare_ - 1];
      const std::size_t n = std::min(spare.bytes, most - filled) / kLargePage * kLargePage;
      remove_spare(n_spare_ - 1);
      const bool moved = n == 0 || move_pages(spare.begin, s.begin + filled, n);
      filled += n;
      const Span rest{spare.begin + n, spare.bytes - n};
      if (rest.bytes >= kLargePage) {
        keep(rest);
        return moved;
      }
      if (rest.bytes > 0) munmap(rest.begin, rest.bytes);
      if (!moved) return false;
    }
    return true;
  }
  void keep(Span s) noexcept {
    if (n_spare_ == kSpares) drop_spare(0);
    spares_[n_spare_++] = s, spare_ += s.bytes;
    while (n_spare_ > 1 && spare_ > most_ / kSpareShare) drop_spare(0);
  }
  void drop_spare(std::size_t i) noexcept {
    munmap(spares_[i].begin, spares_[i].bytes);
    remove_spare(i);
  }
  void remove_spare(std::size_t i) noexcept {  // the order of age is kept: the oldest go first
    spare_ -= spares_[i].bytes;
    std::copy(spares_.data() + i + 1, spares_.data() + n_spare_, spares_.data() + i);
    --n_spare_;
  }

  static constexpr std::size_t kSpares = 64, kSpareShare = 8;
  std::mutex guard_;
  UsedSpans used_;
  std::size_t in_use_ = 0, most_ = 0, spare_ = 0, n_spare_ = 0;  // bytes, but for the last
  std::array<Span, kSpares> spares_{};
};

constinit LargeBlocks large_blocks;
constinit bool wanted = false;  ///< set before there are threads

void* allocate(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) {
  if (wanted && size >= kLargeBlock && alignment <= kLargePage) {
    if (void* const p = large_blocks.allocate(size)) return p;
  }
  const std::size_t whole = rounded_up(size == 0 ? 1 : size, alignment);
  for (;;) {
    void* const p = alignment <= alignof(std::max_align_t) ? std::malloc(whole) : std::aligned_alloc(alignment, whole);
    if (p != nullptr) return p;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void release(void* p) noexcept {
  const bool perhaps = p != nullptr && reinterpret_cast<std::uintptr_t>(p) % kLargePage == 0;
  // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): this is what operator delete calls
  if (!perhaps || !large_blocks.release(p)) std::free(p);
}

}  // namespace

void use_large_blocks() noexcept {
  const char* const choice = std::getenv("SKEIN_LARGE_PAGES");
  wanted = choice == nullptr || choice[0] != '0';
#if defined(__GLIBC__)
  // Set at all, these stay as they are; otherwise they rise with each block that is freed, and so does what stays in
  // the heap. Its own environment variables come first.
  constexpr int kKept = 128 << 10;
  if (std::getenv("MALLOC_TRIM_THRESHOLD_") == nullptr) mallopt(M_TRIM_THRESHOLD, kKept);
  if (std::getenv("MALLOC_MMAP_THRESHOLD_") == nullptr) mallopt(M_MMAP_THRESHOLD, kKept);
#endif
}

void give_back_spare_blocks() noexcept { large_blocks.give_back_spares(); }

}  // namespace skein::app

// The array forms and those that return nullptr call these.
void* operator new(std::size_t size) { return skein::app::allocate(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return skein::app::allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* p) noexcept { skein::app::release(p); }
void operator delete(void* p, std::size_t) noexcept { skein::app::release(p); }
void operator delete(void* p, std::align_val_t) noexcept { skein::app::release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { skein::app::release(p); }

#else
namespace skein::app {
void use_large_blocks() noexcept {}  // the sanitizers look after memory themselves
void give_back_spare_blocks() noexcept {}
}  // namespace skein::app
#endif
