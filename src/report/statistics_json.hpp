// Statistics as JSON (names: docs/report.md).
#pragma once
#include "report/json.hpp"
#include "report/statistics.hpp"

namespace skein {

/// tets, vertices, edges, nonpositive_tets, volume, min_volume; with a metric complexity, tets_per_complexity, length
/// {...} and quality {...}; dihedral {...}.
Json to_json(const MeshStatistics& s);

}  // namespace skein
