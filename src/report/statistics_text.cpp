// Statistics as text for people.
#include <fmt/core.h>

#include <numeric>
#include <span>

#include "base/text.hpp"
#include "report/statistics.hpp"

namespace skein {
namespace {

std::string histogram(std::span<const std::int64_t> counts, const std::vector<std::string>& labels) {
  const auto total = static_cast<double>(std::accumulate(counts.begin(), counts.end(), std::int64_t{0}));
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double share = total > 0 ? static_cast<double>(counts[i]) / total : 0;
    text += fmt::format("  {:>13} {:>15} {:6.2f} %  {}", labels[i], grouped(counts[i]), 100 * share, bar(share));
    while (text.back() == ' ') text.pop_back();
    text += '\n';
  }
  return text;
}

std::string lengths_text(const LengthStatistics& s) {
  std::vector<std::string> labels;
  const auto& b = length_bounds();
  labels.push_back(fmt::format("< {:.2f}", b.front()));
  for (std::size_t i = 1; i < b.size(); ++i) labels.push_back(fmt::format("{:.2f} - {:.2f}", b[i - 1], b[i]));
  labels.push_back(fmt::format(">= {:.2f}", b.back()));
  return fmt::format(
             "\nedge lengths in the metric: {:.2f} % in [0.71, 1.41], min {:.4g}, 1 % {:.4g}, mean {:.4g}, "
             "99 % {:.4g}, max {:.4g}\n",
             s.unit_share, s.min, s.p1, s.mean, s.p99, s.max) +
         histogram(s.histogram, labels);
}

std::string quality_text(const QualityStatistics& s) {
  std::vector<std::string> labels;
  for (int i = 0; i < 10; ++i) labels.push_back(fmt::format("{:.1f} - {:.1f}", 0.1 * i, 0.1 * (i + 1)));
  return fmt::format("\nquality (mean ratio in the metric): min {:.4g}, 0.1 % {:.4g}, 1 % {:.4g}, mean {:.4g}\n", s.min,
                     s.p01, s.p1, s.mean) +
         histogram(s.histogram, labels);
}

std::string dihedral_text(const DihedralStatistics& s) {
  std::vector<std::string> labels;
  for (int i = 0; i < 18; ++i) labels.push_back(fmt::format("{} - {}", 10 * i, 10 * (i + 1)));
  return fmt::format("\ndihedral angles: min {:.2f}, max {:.2f} degrees\n", s.min, s.max) +
         histogram(s.histogram_10deg, labels);
}

}  // namespace

std::string to_text(const MeshStatistics& s) {
  std::string text = fmt::format("{} tetrahedra, {} vertices, {} edges, volume {:.9g}, smallest {:.4g}\n",
                                 grouped(s.tets), grouped(s.vertices), grouped(s.edges), s.volume, s.min_volume);
  if (s.nonpositive_tets > 0) text += fmt::format("{} tetrahedra are inverted or flat\n", grouped(s.nonpositive_tets));
  if (s.with_metric) {
    text += fmt::format("complexity {:.6g}, {:.4g} tetrahedra per unit of it\n", s.complexity,
                        static_cast<double>(s.tets) / s.complexity);
    text += lengths_text(s.length) + quality_text(s.quality);
  }
  return text + dihedral_text(s.dihedral);
}

}  // namespace skein
