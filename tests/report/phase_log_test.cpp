// The phase log: sums over ranks, balance, and the JSON made of it.
#include "comm/phase_log.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/text.hpp"
#include "comm/exchange.hpp"
#include "report/json.hpp"
#include "tests/support/world.hpp"

namespace skein {
namespace {

TEST(PhaseLog, AddsUpOverRanks) {
  const Comm& comm = test::world();
  const auto r = static_cast<std::int64_t>(num(comm.rank())), ranks = static_cast<std::int64_t>(comm.size());
  PhaseLog log(comm, PhaseLog::Output::kQuiet);
  log.start("first");
  log.count("insert", 10);
  log.count("insert", r);
  if (r == ranks - 1) log.count("only the last", 3);  // ranks need not name the same operations
  log.busy(1);
  log.busy(r == 0 ? 1 : 0);
  log.finish(100 + r);
  log.start("second");
  log.finish(5);

  ASSERT_EQ(log.phases().size(), 2U);
  const PhaseCost& p = log.phases()[0];
  EXPECT_EQ(p.name, "first");
  EXPECT_EQ(p.elements, 100 * ranks + ranks * (ranks - 1) / 2);
  EXPECT_EQ(p.elements_max, 100 + ranks - 1);
  EXPECT_EQ(p.operations.at("insert"), 10 * ranks + ranks * (ranks - 1) / 2);
  EXPECT_EQ(p.operations.at("only the last"), 3);
  EXPECT_DOUBLE_EQ(p.busy_max, 2);
  EXPECT_DOUBLE_EQ(p.busy_min, ranks == 1 ? 2 : 1);
  EXPECT_DOUBLE_EQ(p.balance, 100.0 * static_cast<double>(ranks + 1) / static_cast<double>(ranks) / 2);
  EXPECT_LE(p.seconds_min, p.seconds_mean);
  EXPECT_LE(p.seconds_mean, p.seconds_max);
  EXPECT_TRUE(log.phases()[1].operations.empty());
  EXPECT_EQ(to_json(p)["operations"]["only the last"], 3);
}

/// Uses this many CPU seconds.
void compute(double seconds) {
  const double end = cpu_time() + seconds;
  while (cpu_time() < end) {
  }
}

TEST(PhaseLog, TellsWorkFromWaiting) {
  const Comm& comm = test::world();
  const auto ranks = static_cast<std::int64_t>(comm.size());
  PhaseLog log(comm, PhaseLog::Output::kQuiet);
  log.start("rank 0 works, the others wait");
  if (comm.is_root()) compute(0.2);
  comm.barrier();
  log.finish(0);
  const PhaseCost& p = log.phases()[0];
  EXPECT_GE(p.cpu_max, 0.2);
  EXPECT_LE(p.cpu_max, p.seconds_max + 0.01);
  if (ranks > 1) {
    EXPECT_LT(p.cpu_min, 0.1);
  }
  EXPECT_LE(p.comm_cpu_min, p.comm_cpu_mean);
  EXPECT_LE(p.comm_cpu_mean, p.comm_cpu_max);
  EXPECT_EQ(p.collectives, ranks == 1 ? 0 : 1);
  EXPECT_EQ(p.messages_sent, 0);
  EXPECT_EQ(to_json(p)["cpu"]["max"], p.cpu_max);
}

TEST(PhaseLog, CountsMessages) {
  const Comm& comm = test::world();
  const int ranks = comm.size(), self = num(comm.rank());
  PhaseLog log(comm, PhaseLog::Output::kQuiet);
  log.start("all to rank 0");
  Packets<double> send;
  if (self != 0) {
    send.rank.push_back(Rank{0});
    send.items.assign(static_cast<std::size_t>(100 * self), 1.0);
    send.offset.push_back(send.items.size());
  }
  static_cast<void>(exchange(comm, send));
  log.finish(0);
  const PhaseCost& p = log.phases()[0];
  EXPECT_EQ(p.messages_sent, 2 * (ranks - 1));
  EXPECT_EQ(p.messages_sent_max, ranks > 1 ? 2 : 0);
  EXPECT_GE(p.bytes_sent, 400 * ranks * (ranks - 1));
  EXPECT_GE(p.bytes_sent_max, 800 * (ranks - 1));
  EXPECT_LE(p.bytes_sent_max, p.bytes_sent);
}

TEST(PhaseLog, PrintsOneLineForAPhase) {
  const Comm& comm = test::world();
  testing::internal::CaptureStdout();
  PhaseLog log(comm, PhaseLog::Output::kPlain);
  log.start("work");
  log.finish(1234567);
  log.note("a note");
  const std::string out = testing::internal::GetCapturedStdout();
  if (!comm.is_root()) {
    EXPECT_EQ(out, "");
    return;
  }
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 2);
  EXPECT_NE(out.find(grouped(1234567 * comm.size()) + " tets"), std::string::npos) << out;
  EXPECT_NE(out.find("a note\n"), std::string::npos);
  EXPECT_EQ(out.find('\r'), std::string::npos);
}

TEST(Json, IsWrittenWholeOrNotAtAll) {
  const Comm& comm = test::world();
  const auto folder = std::filesystem::temp_directory_path() /
                      ("skein-json-" + std::to_string(comm.broadcast(static_cast<std::int64_t>(getpid()))));
  if (comm.is_root()) std::filesystem::create_directory(folder);
  comm.barrier();
  write_json(comm, folder / "report.json", Json{{"b", 1}, {"a", {1, 2}}});
  EXPECT_THROW(write_json(comm, folder / "missing" / "report.json", Json{}), Error);
  if (!comm.is_root()) return;
  std::ifstream file(folder / "report.json");
  EXPECT_EQ(Json::parse(file).dump(), R"({"b":1,"a":[1,2]})");  // in the order in which they were put
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  std::filesystem::remove_all(folder);
}

TEST(Text, GroupsDigitsAndDrawsBars) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(-123456), "-123,456");
  EXPECT_EQ(bar(0), "");
  EXPECT_EQ(bar(0.0001, 10), "#");
  EXPECT_EQ(bar(0.5, 10), "#####");
}

}  // namespace
}  // namespace skein
