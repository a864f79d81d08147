// The sources file: point, line and triangle sources in TOML (docs/sources.md).
#pragma once
#include <string>
#include <string_view>

#include "comm/comm.hpp"
#include "metric/spacing.hpp"

namespace skein {

/// The sources written in `text`. Throws Error(kInput) naming `path`, line and key.
SpacingField parse_sources(std::string_view text, const std::string& path);

/// Collective. Read by rank 0; the same field on every rank. Throws Error(kInput) on all ranks.
SpacingField read_sources(const Comm& comm, const std::string& path);

}  // namespace skein
