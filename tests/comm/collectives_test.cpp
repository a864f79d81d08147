// Collectives of Comm, and agree().
#include <gtest/gtest.h>

#include <limits>
#include <new>

#include "tests/support/world.hpp"

namespace skein {
namespace {

using test::world;

template <class T>
std::vector<T> values_by_rank(T (*f)(int)) {
  std::vector<T> out;
  for (int r = 0; r < world().size(); ++r) out.push_back(f(r));
  return out;
}

TEST(Collectives, reduce_equals_serial) {
  const auto value = [](int r) { return std::int64_t{r} * r - 3; };
  std::int64_t sum = 0, low = std::numeric_limits<std::int64_t>::max(), high = -low;
  for (int r = 0; r < world().size(); ++r)
    sum += value(r), low = std::min(low, value(r)), high = std::max(high, value(r));
  const std::int64_t mine = value(num(world().rank()));
  EXPECT_EQ(world().sum(mine), sum);
  EXPECT_EQ(world().min(mine), low);
  EXPECT_EQ(world().max(mine), high);
  EXPECT_EQ(world().sum(static_cast<double>(mine)), static_cast<double>(sum));
  EXPECT_EQ(world().min(static_cast<double>(mine)), static_cast<double>(low));
  EXPECT_EQ(world().max(static_cast<double>(mine)), static_cast<double>(high));
  EXPECT_EQ(world().sum(std::int32_t{1}), world().size());
  EXPECT_EQ(world().max(std::uint64_t{1} << 63), std::uint64_t{1} << 63);
}

TEST(Collectives, sums_of_doubles_have_the_same_bits_on_all_ranks_and_each_time) {
  const double wild[] = {1e16, 1.0, -1e16, 0.1};
  std::vector<double> v(70001);
  for (std::size_t i = 0; i < v.size(); ++i)
    v[i] = wild[(i + idx(world().rank())) % 4] * (1.0 + 1e-3 * static_cast<double>(i));
  std::vector<double> first = v, again = v;
  world().reduce(std::span(first), Op::kSum);
  world().reduce(std::span(again), Op::kSum);
  EXPECT_EQ(first, again);
  for (const std::size_t i : {std::size_t{0}, std::size_t{3}, v.size() - 1}) {
    for (const double other : world().all_gather(first[i])) EXPECT_EQ(other, first[i]);
    // One at a time or many together: the same.
    EXPECT_EQ(world().sum(v[i]), first[i]);
  }
}

TEST(Collectives, reduce_of_an_array_is_element_by_element) {
  std::vector<std::int64_t> v{num(world().rank()), -num(world().rank()), 7};
  world().reduce(std::span(v), Op::kMax);
  EXPECT_EQ(v, (std::vector<std::int64_t>{world().size() - 1, 0, 7}));
  std::vector<double> none;
  world().reduce(std::span(none), Op::kSum);
}

TEST(Collectives, exclusive_sum_is_the_sum_over_lower_ranks) {
  const std::int64_t r = num(world().rank());
  EXPECT_EQ(world().exclusive_sum(r + 1), r * (r + 1) / 2);
  EXPECT_EQ(world().exclusive_sum(0.5), 0.5 * static_cast<double>(r));
}

TEST(Collectives, all_gather_of_values_and_of_vectors) {
  struct Item {
    double a;
    std::int32_t b;
  };
  const auto items = world().all_gather(Item{1.5, num(world().rank())});
  EXPECT_EQ(items.size(), static_cast<std::size_t>(world().size()));
  for (std::size_t r = 0; r < items.size(); ++r) EXPECT_EQ(items[r].b, static_cast<std::int32_t>(r));

  // Rank r gives r items, so rank 0 none.
  const std::vector<std::int16_t> mine(idx(world().rank()), static_cast<std::int16_t>(num(world().rank())));
  std::vector<std::int16_t> all;
  for (int r = 0; r < world().size(); ++r)
    all.insert(all.end(), static_cast<std::size_t>(r), static_cast<std::int16_t>(r));
  EXPECT_EQ(world().all_gather(mine), all);
  EXPECT_EQ(world().gather(mine), world().is_root() ? all : std::vector<std::int16_t>{});
}

TEST(Collectives, broadcast_gives_the_value_of_rank_0) {
  EXPECT_EQ(world().broadcast(num(world().rank())), 0);
  EXPECT_EQ(world().broadcast(std::string(idx(world().rank()) + 5, 'x')), "xxxxx");
  EXPECT_EQ(world().broadcast(std::string(world().is_root() ? "" : "lost")), "");
}

TEST(Collectives, self_is_alone) {
  const Comm self = Comm::self();
  EXPECT_EQ(self.size(), 1);
  EXPECT_TRUE(self.is_root());
  EXPECT_EQ(self.sum(3.5), 3.5);
  EXPECT_EQ(self.bytes_sent(), 0);
  EXPECT_EQ(self.messages_sent(), 0);
  EXPECT_EQ(self.collective_calls(), 0);
}

TEST(Collectives, count_their_calls_and_cpu_time) {
  const Comm comm = Comm::world();
  comm.barrier();
  static_cast<void>(comm.sum(1.0));
  EXPECT_EQ(comm.collective_calls(), comm.size() == 1 ? 0 : 2);
  EXPECT_EQ(comm.messages_sent(), 0);
  EXPECT_GT(comm.communication_cpu(), 0);
  EXPECT_LE(comm.communication_cpu(), cpu_time());
}

TEST(Collectives, a_moved_comm_stays_usable) {
  Comm a = Comm::world();
  Comm b = std::move(a);
  a = Comm::self();
  EXPECT_EQ(a.size(), 1);
  EXPECT_EQ(b.sum(std::int32_t{1}), world().size());
}

TEST(Collectives, clocks_and_memory) {
  const double wall = wall_time(), cpu = cpu_time();
  volatile double x = 0;
  for (int i = 0; i < 2000000; ++i) x = x + 1;
  EXPECT_GT(wall_time(), wall);
  EXPECT_GT(cpu_time(), cpu);
  EXPECT_GT(peak_memory(), 1 << 20);
}

/// What agree throws here: code and line, "" when nothing.
std::pair<ExitCode, std::string> verdict(const std::function<void()>& work) {
  try {
    agree(world(), work);
  } catch (const AgreedError& e) {
    return {e.code(), e.what()};
  }
  return {ExitCode::kOk, ""};
}

TEST(Agree, nothing_happens_when_all_succeed) {
  int calls = 0;
  EXPECT_EQ(verdict([&] { ++calls; }).first, ExitCode::kOk);
  EXPECT_EQ(calls, 1);
}

TEST(Agree, the_error_of_one_rank_reaches_all) {
  for (int bad = 0; bad < world().size(); ++bad) {
    const auto got = verdict([&] {
      if (num(world().rank()) == bad) throw Error(ExitCode::kInput, "wing.meshb: rank " + std::to_string(bad));
    });
    EXPECT_EQ(got.first, ExitCode::kInput);
    EXPECT_EQ(got.second, "wing.meshb: rank " + std::to_string(bad));
  }
}

TEST(Agree, the_lowest_failing_rank_speaks) {
  const int last = world().size() - 1;
  const auto got = verdict([&] {
    if (num(world().rank()) == last) throw Error(ExitCode::kOutput, "last");
    if (num(world().rank()) >= last / 2) throw Error(ExitCode::kInput, "rank " + std::to_string(num(world().rank())));
  });
  EXPECT_EQ(got.second, last == 0 ? "last" : "rank " + std::to_string(last / 2));
}

TEST(Agree, other_exceptions_become_one_line) {
  const auto memory = verdict([&] {
    if (world().is_root()) throw std::bad_alloc();
  });
  EXPECT_EQ(memory.first, ExitCode::kInternal);
  EXPECT_NE(memory.second.find("out of memory"), std::string::npos);
  const auto lines = verdict([] { throw std::runtime_error("two\nlines"); });
  EXPECT_EQ(lines.first, ExitCode::kInternal);
  EXPECT_NE(lines.second.find("two lines"), std::string::npos);
  EXPECT_EQ(verdict([] { throw 42; }).first, ExitCode::kInternal);
}

}  // namespace
}  // namespace skein
