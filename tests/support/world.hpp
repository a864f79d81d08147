// What tests on several ranks share: all ranks of the run, made by skein_test_main.
#pragma once
#include "comm/comm.hpp"

namespace skein::test {

/// All ranks of the test run. Tests run in the same order on every rank; a test that uses collectives must not skip
/// them on some ranks (use EXPECT_*, not ASSERT_*, between collectives).
const Comm& world() noexcept;

}  // namespace skein::test
