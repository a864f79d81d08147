// The one exception of Skein: a clear line for the user and an exit code. It is part of the public headers.
#pragma once
#include "skein/error.hpp"

namespace skein {

/// Exit codes of the command line (documented in docs/cli.md).
using ExitCode = ErrorCode;

}  // namespace skein
