// Sparse exchange and replies.
#include "comm/exchange.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "tests/support/world.hpp"

namespace skein {
namespace {

using test::world;

struct Item {
  std::int32_t from, to;
  std::int64_t serial;
};

/// Every rank sends `count(from, to)` items to every rank; checks that all arrive, in order, sorted by source.
template <class Count>
void check_all_pairs(Count count) {
  const std::int32_t self = num(world().rank());
  std::vector<Rank> dest;
  std::vector<Item> items;
  // Interleaved and in falling order of destination, so that pack has to sort.
  for (std::int64_t serial = 0, more = 1; more != 0; ++serial) {
    more = 0;
    for (std::int32_t to = world().size() - 1; to >= 0; --to) {
      if (serial >= count(self, to)) continue;
      dest.push_back(Rank{to});
      items.push_back({self, to, serial});
      more = 1;
    }
  }
  const auto got = exchange(world(), std::span<const Rank>(dest), std::span<const Item>(items));
  const auto same = [](const Item& a, const Item& b) {
    return a.from == b.from && a.to == b.to && a.serial == b.serial;
  };
  const auto moved = exchange(world(), pack(std::span<const Rank>(dest), std::move(items)));
  EXPECT_EQ(moved.rank, got.rank);
  EXPECT_EQ(moved.offset, got.offset);
  EXPECT_TRUE(std::ranges::equal(moved.items, got.items, same));
  std::size_t block = 0;
  for (std::int32_t from = 0; from < world().size(); ++from) {
    if (count(from, self) == 0) continue;
    ASSERT_LT(block, got.blocks());
    EXPECT_EQ(got.rank[block], Rank{from});
    EXPECT_EQ(got.block(block).size(), static_cast<std::size_t>(count(from, self)));
    std::int64_t wrong = 0, serial = 0;
    for (const Item& i : got.block(block)) wrong += i.from != from || i.to != self || i.serial != serial++;
    EXPECT_EQ(wrong, 0);
    ++block;
  }
  EXPECT_EQ(block, got.blocks());
  EXPECT_EQ(got.offset.back(), got.items.size());
}

TEST(Exchange, nothing_at_all) {
  check_all_pairs([](int, int) { return 0; });
}
TEST(Exchange, only_to_oneself) {
  const auto before = world().bytes_sent();
  check_all_pairs([](int from, int to) { return from == to ? 5 : 0; });
  EXPECT_EQ(world().bytes_sent(), before);
}
TEST(Exchange, all_to_all) {
  check_all_pairs([](int, int) { return 3; });
}
TEST(Exchange, some_pairs_only) {
  check_all_pairs([](int from, int to) { return (from + 2 * to) % 3; });
}
TEST(Exchange, all_to_the_last_rank) {
  check_all_pairs([](int from, int to) { return to == world().size() - 1 ? from + 1 : 0; });
}
TEST(Exchange, large_blocks) {
  check_all_pairs([](int from, int to) { return from == 0 ? 200000 : 100 * to; });
}
TEST(Exchange, many_in_a_row_do_not_mix) {
  for (int k = 0; k < 200; ++k) check_all_pairs([&](int from, int to) { return (from * 7 + to * 3 + k) % 4; });
}

TEST(Exchange, counts_the_bytes_sent_to_others) {
  const auto before = world().bytes_sent(), messages = world().messages_sent();
  Packets<double> send;
  for (int r = 0; r < world().size(); ++r) {
    send.rank.push_back(Rank{r});
    send.items.insert(send.items.end(), 1000, 1.0);
    send.offset.push_back(send.items.size());
  }
  static_cast<void>(exchange(world(), send));
  const auto sent = world().bytes_sent() - before;
  EXPECT_GE(sent, 8000 * (world().size() - 1));
  EXPECT_LE(sent, 8100 * (world().size() - 1));
  EXPECT_EQ(world().messages_sent() - messages, 2 * (world().size() - 1));  // announcement and block
}

TEST(Exchange, empty_blocks_are_left_out) {
  Packets<std::int32_t> send;
  for (int r = 0; r < world().size(); ++r) {
    send.rank.push_back(Rank{r});
    if (r % 2 == 0) send.items.push_back(r);
    send.offset.push_back(send.items.size());
  }
  const auto got = exchange(world(), send);
  EXPECT_EQ(got.blocks(), num(world().rank()) % 2 == 0 ? static_cast<std::size_t>(world().size()) : 0U);
}

TEST(Exchange, replies_come_in_the_order_of_the_questions) {
  // Questions to pseudo-random ranks; the answer tells the question and who answered.
  struct Answer {
    std::int64_t question;
    std::int32_t by;
  };
  std::vector<Rank> dest;
  std::vector<std::int64_t> questions;
  for (std::int64_t i = 0; i < 100 * num(world().rank()); ++i) {  // rank 0 asks nothing
    dest.push_back(to_id<Rank>((i * i + 3 * i) % world().size()));
    questions.push_back(1000000 * num(world().rank()) + i);
  }
  const auto sent = pack(std::span<const Rank>(dest), std::span<const std::int64_t>(questions));
  const auto asked = exchange(world(), sent);
  std::vector<Answer> answers;
  for (const auto q : asked.items) answers.push_back({q, num(world().rank())});
  const auto got = reply(world(), sent, asked, std::span<const Answer>(answers));
  EXPECT_EQ(got.size(), sent.items.size());
  for (std::size_t b = 0; b < sent.blocks(); ++b) {
    for (std::size_t i = sent.offset[b]; i < sent.offset[b + 1]; ++i) {
      EXPECT_EQ(got[i].question, sent.items[i]);
      EXPECT_EQ(got[i].by, num(sent.rank[b]));
    }
  }
}

TEST(Pack, is_stable) {
  const std::vector<Rank> dest{Rank{7}, Rank{2}, Rank{7}, Rank{0}, Rank{2}};
  const std::vector<std::int32_t> items{10, 11, 12, 13, 14};
  const auto p = pack(std::span<const Rank>(dest), std::span<const std::int32_t>(items));
  EXPECT_EQ(p.rank, (std::vector<Rank>{Rank{0}, Rank{2}, Rank{7}}));
  EXPECT_EQ(p.items, (std::vector<std::int32_t>{13, 11, 14, 10, 12}));
  EXPECT_EQ(p.offset, (std::vector<std::size_t>{0, 1, 3, 5}));
}

TEST(Pack, of_what_is_not_needed_any_more_is_the_same) {
  for (const int ranks : {1, 3}) {  // all to rank 2, or to 2, 3 and 4
    std::vector<Rank> dest;
    std::vector<std::int32_t> items;
    for (std::int32_t i = 0; i < 10; ++i) {
      dest.push_back(Rank{2 + i % ranks});
      items.push_back(i);
    }
    const auto copied = pack(std::span<const Rank>(dest), std::span<const std::int32_t>(items));
    const auto moved = pack(std::span<const Rank>(dest), std::move(items));
    EXPECT_EQ(moved.rank, copied.rank);
    EXPECT_EQ(moved.offset, copied.offset);
    EXPECT_EQ(moved.items, copied.items);
  }
  const auto none = pack(std::span<const Rank>(), std::vector<std::int32_t>());
  EXPECT_EQ(none.blocks(), 0U);
}

}  // namespace
}  // namespace skein
