// The program's operator new and delete: blocks do not overlap, are aligned, and are given back, with threads too.
#include "app/large_blocks.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>
#include <random>
#include <vector>

#include "base/parallel.hpp"

namespace skein::test {
namespace {

struct Block {
  std::unique_ptr<std::uint64_t[]> data;
  std::size_t words = 0;
  std::uint64_t mark = 0;

  explicit Block(std::size_t n, std::uint64_t m) : data(new std::uint64_t[n]), words(n), mark(m) {
    std::fill(data.get(), data.get() + n, m);
  }
  [[nodiscard]] bool intact() const {
    return std::all_of(data.get(), data.get() + words, [&](std::uint64_t w) { return w == mark; });
  }
};

/// Sizes on both sides of the bound and of the page sizes, in an order without pattern.
void come_and_go(std::uint64_t seed) {
  constexpr std::size_t kMega = std::size_t{1} << 17;  // of words
  std::mt19937_64 random(seed);
  std::vector<Block> held;
  for (int step = 0; step < 300; ++step) {
    const std::size_t base =
        std::vector<std::size_t>{100, kMega - 1, kMega, 2 * kMega, 3 * kMega + 17, 5 * kMega}[random() % 6];
    held.emplace_back(base + random() % 1000, seed * 1000 + static_cast<std::uint64_t>(step));
    if (held.size() < 8) continue;
    const std::size_t gone = random() % held.size();
    ASSERT_TRUE(held[gone].intact());
    std::swap(held[gone], held.back());
    held.pop_back();
  }
  for (const Block& b : held) ASSERT_TRUE(b.intact());
}

TEST(LargeBlocks, DoNotOverlap) { come_and_go(1); }

TEST(LargeBlocks, DoNotOverlapWithThreads) {
  in_parallel(3, [](int w) { come_and_go(static_cast<std::uint64_t>(w) + 2); });
}

TEST(LargeBlocks, AreAligned) {
  struct alignas(64) Line {
    double x[8];
  };
  struct alignas(4096) Page {
    char x[4096];
  };
  for (const std::size_t n : {1, 3, 1000, 100'000}) {
    const std::vector<Line> lines(n);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.data()) % alignof(Line), 0u);
    if (n > 1000) continue;
    const std::vector<Page> pages(n);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pages.data()) % alignof(Page), 0u);
  }
}

#if !defined(SKEIN_SANITIZED)  // these end the program
/// Share of a block's pages that are in memory.
double resident(const std::vector<char>& block) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(block.data()) / page * page;
  std::vector<unsigned char> in_memory((block.capacity() + page - 1) / page);
  EXPECT_EQ(mincore(reinterpret_cast<void*>(begin), block.capacity(), in_memory.data()), 0);
  const auto n = std::count_if(in_memory.begin(), in_memory.end(), [](unsigned char c) { return (c & 1) != 0; });
  return static_cast<double>(n) / static_cast<double>(in_memory.size());
}

TEST(LargeBlocks, TakeThePagesOfSmallerOnesThatAreGone) {
  constexpr std::size_t kMega = std::size_t{1} << 20;
  std::vector<char> most;
  most.reserve(400 * kMega);  // so much may be kept of it later, untouched as it is
  { std::vector<char>().swap(most); }
  std::vector<std::vector<char>> small;
  for (int i = 0; i < 4; ++i) small.emplace_back(10 * kMega, 'x');
  small.clear();
  std::vector<char> large;
  large.reserve(45 * kMega);
  const double there = resident(large);
  EXPECT_GT(there, 0.5);
  EXPECT_LT(there, 0.75);  // the rest comes when it is touched
  large.assign(45 * kMega, 'y');
  EXPECT_EQ(std::count(large.begin(), large.end(), 'y'), std::ssize(large));
}

TEST(LargeBlocks, MoreThanCanBeIsAnError) { EXPECT_THROW(std::vector<char>(std::size_t{1} << 60), std::bad_alloc); }
#endif

}  // namespace
}  // namespace skein::test

int main(int argc, char** argv) {
  skein::app::use_large_blocks();
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
