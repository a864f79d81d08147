// Statistics as JSON.
#include "report/statistics_json.hpp"

namespace skein {

Json to_json(const MeshStatistics& s) {
  Json j{{"tets", s.tets},     {"vertices", s.vertices},
         {"edges", s.edges},   {"nonpositive_tets", s.nonpositive_tets},
         {"volume", s.volume}, {"min_volume", s.min_volume}};
  if (s.with_metric) {
    const LengthStatistics& l = s.length;
    const QualityStatistics& q = s.quality;
    j["complexity"] = s.complexity;
    j["tets_per_complexity"] = static_cast<double>(s.tets) / s.complexity;
    j["length"] = {{"unit_share", l.unit_share},
                   {"min", l.min},
                   {"p1", l.p1},
                   {"mean", l.mean},
                   {"p99", l.p99},
                   {"max", l.max},
                   {"below_0.5", l.below_half},
                   {"above_2", l.above_two}};
    j["quality"] = {{"min", q.min},
                    {"p0.1", q.p01},
                    {"p1", q.p1},
                    {"mean", q.mean},
                    {"below_0.1", q.below_01},
                    {"below_0.2", q.below_02},
                    {"above_0.5", q.above_05},
                    {"above_0.8", q.above_08}};
  }
  j["dihedral"] = {{"min", s.dihedral.min}, {"max", s.dihedral.max}, {"histogram_10deg", s.dihedral.histogram_10deg}};
  return j;
}

}  // namespace skein
