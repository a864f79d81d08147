// Large arrays of the program come straight from the system, in large pages: operator new and delete of the process.
//
// A mesh is walked through by ids that lie far from each other, so with pages of 4 kB much of the time goes into
// finding pages, and each page costs again when it is first touched. And an allocator that keeps what is freed in its
// heap lets the process grow by what lies between (docs/decisions.md, 36). What is smaller goes to malloc.
#include "app/large_blocks.hpp"

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#include <sys/mman.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>

namespace skein::app {
namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;  ///< bytes; of x86-64 and of most others
constexpr std::size_t kSmallPage = std::size_t{4} << 10;
constexpr std::size_t kLargeBlock = std::size_t{1} << 20;  ///< from here on

constexpr std::size_t rounded_up(std::size_t n, std::size_t unit) noexcept { return (n + unit - 1) / unit * unit; }

/// The blocks that are in use: an open table of start and size. It has room for far more than a process has at a time;
/// when it is full, malloc serves.
class Blocks {
 public:
  bool insert(void* p, std::size_t bytes) {
    const std::lock_guard hold(guard_);
    if (used_ == kSlots / 2) return false;
    std::size_t at = home(p);
    while (start_[at] != nullptr) at = next(at);
    start_[at] = p, bytes_[at] = bytes, ++used_;
    return true;
  }
  /// Size of the block that starts at p, which is none of the table's any more; 0 if it was none.
  std::size_t take(void* p) {
    const std::lock_guard hold(guard_);
    std::size_t at = home(p);
    while (start_[at] != p) {
      if (start_[at] == nullptr) return 0;
      at = next(at);
    }
    const std::size_t bytes = bytes_[at];
    --used_;
    for (std::size_t gap = at;;) {  // whoever was pushed on by the gap's block moves back
      start_[gap] = nullptr;
      do {
        at = next(at);
        if (start_[at] == nullptr) return bytes;
      } while (((at - home(start_[at])) & (kSlots - 1)) < ((at - gap) & (kSlots - 1)));
      start_[gap] = start_[at], bytes_[gap] = bytes_[at], gap = at;
    }
  }

 private:
  static constexpr std::size_t kSlots = 4096;
  static std::size_t home(void* p) noexcept {
    return static_cast<std::size_t>(reinterpret_cast<std::uintptr_t>(p) / kLargePage * 0x9e3779b97f4a7c15ULL >> 52);
  }
  static std::size_t next(std::size_t at) noexcept { return (at + 1) & (kSlots - 1); }

  std::mutex guard_;
  std::size_t used_ = 0;
  std::array<void*, kSlots> start_{};
  std::array<std::size_t, kSlots> bytes_{};
};

constinit Blocks blocks;
constinit bool in_use = false;  ///< set before there are threads

/// A block that begins at a large page's border; nullptr if there is none to be had. Its last part stays in small
/// pages, so that it takes no more memory than was asked for.
void* map_block(std::size_t size) noexcept {
  const std::size_t bytes = rounded_up(size, kSmallPage), with_slack = bytes + kLargePage;
  void* const raw = mmap(nullptr, with_slack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (raw == MAP_FAILED) return nullptr;
  char* const begin = static_cast<char*>(raw);
  const std::size_t before =
      rounded_up(reinterpret_cast<std::uintptr_t>(raw), kLargePage) - reinterpret_cast<std::uintptr_t>(raw);
  char* const p = begin + before;
  if (before > 0) munmap(begin, before);
  if (kLargePage > before) munmap(p + bytes, kLargePage - before);
  const std::size_t in_large_pages = bytes / kLargePage * kLargePage;
  if (in_large_pages > 0) madvise(p, in_large_pages, MADV_HUGEPAGE);  // a wish; without it the block is as good
  if (blocks.insert(p, bytes)) return p;
  munmap(p, bytes);
  return nullptr;
}

void* allocate(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) {
  if (in_use && size >= kLargeBlock && alignment <= kLargePage) {
    if (void* const p = map_block(size)) return p;
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
  if (reinterpret_cast<std::uintptr_t>(p) % kLargePage == 0 && p != nullptr) {
    if (const std::size_t bytes = blocks.take(p)) {
      munmap(p, bytes);
      return;
    }
  }
  std::free(p);
}

}  // namespace

void use_large_blocks() noexcept {
  const char* const choice = std::getenv("SKEIN_LARGE_PAGES");
  in_use = choice == nullptr || choice[0] != '0';
}

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
}  // namespace skein::app
#endif
