// How a piece of work ended on a rank, and how the ranks agree on it. Private to comm/.
#pragma once
#include <functional>
#include <string>

#include "comm/comm.hpp"

namespace skein {

struct Verdict {
  ExitCode code = ExitCode::kOk;
  std::string line;
  bool agreed = false;  ///< all ranks have this error
};

/// Runs `work`; tells what it threw, if anything. Not collective.
Verdict verdict_of(const Comm& comm, const std::function<void()>& work);

/// Collective. Throws the same AgreedError on all ranks if any has an error: that of the lowest one which has.
void agree_on(const Comm& comm, const Verdict& mine);

}  // namespace skein
