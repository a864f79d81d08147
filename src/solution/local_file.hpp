// The file of local sizes: rules by patch and region in TOML (docs/local.md).
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "comm/comm.hpp"
#include "solution/local_sizes.hpp"

namespace skein {

/// The rules written in `text`. Throws Error(kInput) naming `path`, line and key.
std::vector<LocalRule> parse_local(std::string_view text, const std::string& path);

/// Collective. Read by rank 0; the same rules on every rank. Throws Error(kInput) on all ranks.
std::vector<LocalRule> read_local(const Comm& comm, const std::string& path);

}  // namespace skein
