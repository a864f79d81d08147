// The results as JSON (names: docs/report.md), and writing a JSON file.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "comm/comm.hpp"
#include "comm/phase_log.hpp"

namespace skein {

/// Keys stay in the order in which they were put.
using Json = nlohmann::ordered_json;

/// The names are those of docs/report.md.
Json to_json(const PhaseCost& phase);

/// Collective. Rank 0 writes the object under a temporary name beside `path`, then renames it. `json` counts on rank 0
/// only. Throws Error(kOutput) on all ranks.
void write_json(const Comm& comm, const std::string& path, const Json& json);

}  // namespace skein
