// PhaseLog: what is printed, by whom and when.
#include "comm/phase_log.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/world.hpp"

namespace skein::test {
namespace {

std::string output_of(PhaseLog::Output output, double beat) {
  ::testing::internal::CaptureStdout();
  {
    PhaseLog log(world(), output);
    log.beat_every(beat);
    log.expect(1234567);
    log.start("quick");
    log.finish(1000);
    log.start("slow");
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    log.finish(1000);
  }
  std::fflush(stdout);
  return ::testing::internal::GetCapturedStdout();
}

TEST(PhaseLog, LongPhasesAreToldWhileTheyRunOnRankZeroAlone) {
  const std::string text = output_of(PhaseLog::Output::kPlain, 0.1);
  if (!world().is_root()) {
    EXPECT_EQ(text, "");
    return;
  }
  const auto first = text.find("slow"), beat = text.find(" for ");
  ASSERT_NE(beat, std::string::npos) << text;
  EXPECT_LT(first, beat) << "before the line of the finished phase";
  EXPECT_NE(text.find("1,234,567 expected in the end"), std::string::npos) << text;
  EXPECT_EQ(text.find("quick               for"), std::string::npos) << text;
}

TEST(PhaseLog, ShortPhasesAndQuietLogsHaveNoSuchLines) {
  EXPECT_EQ(output_of(PhaseLog::Output::kPlain, 30).find("expected"), std::string::npos);
  EXPECT_EQ(output_of(PhaseLog::Output::kQuiet, 0.1), "");
}

}  // namespace
}  // namespace skein::test
