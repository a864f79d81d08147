// The verdict of the end check.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/invariants.hpp"

namespace skein {
namespace {

class Judge {
 public:
  Judge(const EndCheckLimits& limits, EndCheckReport& report) : limits_(limits), report_(report) {}
  /// The same number or the same set.
  template <class T, class Text>
  void same(const T& before, const T& after, Text&& text) {
    ++report_.compared;
    if (!(before == after)) report_.faults.push_back(text());
  }
  /// `smooth`: what the old value may gain besides.
  void near(double before, double after, double slack, bool curved, const std::string& what, double smooth = 0) {
    ++report_.compared;
    const double low = std::min(before, before + smooth), high = std::max(before, before + smooth);
    const double scale = std::max(std::abs(before), std::abs(after));
    const double apart = std::abs(after - (std::isnan(after) ? before : std::clamp(after, low, high)));
    const double relative = scale > 0 ? apart / scale : 0;
    double& largest = curved ? report_.largest_curved : report_.largest_exact;
    largest = std::max(largest, relative);
    const double share = curved ? limits_.curved : limits_.rounding;
    if (apart <= share * scale + slack) return;  // false for NaN
    report_.faults.push_back(fmt::format("{}: {:.12g} before, {:.12g} after", what, before, after));
  }
  void near(const std::vector<Extent>& before, const std::vector<Extent>& after, double slack, const char* what);
  void roll(const Roll& before, const Roll& after, const char* what) {
    same(before, after, [&] {
      if (before.count == after.count) return fmt::format("{}: one of {} is another", what, before.count);
      return fmt::format("{}: {} before, {} after", what, before.count, after.count);
    });
  }

 private:
  const EndCheckLimits& limits_;
  EndCheckReport& report_;
};

void Judge::near(const std::vector<Extent>& before, const std::vector<Extent>& after, double slack, const char* what) {
  auto i = before.begin(), j = after.begin();
  while (i != before.end() || j != after.end()) {
    const bool old = i != before.end() && (j == after.end() || i->key <= j->key);
    const bool now = j != after.end() && (i == before.end() || j->key <= i->key);
    const std::int64_t key = old ? i->key : j->key;
    near(old ? i->value : 0, now ? j->value : 0, slack, old && i->curved != 0, fmt::format("{} {}", what, key),
         old && i->curved != 0 ? i->smooth : 0);
    if (old) ++i;
    if (now) ++j;
  }
}

void judge_shapes(const Invariants& before, const Invariants& after, Judge& judge) {
  for (std::size_t g = 0; g < before.shapes.size() && g < after.shapes.size(); ++g) {
    const Shape &b = before.shapes[g], &a = after.shapes[g];
    judge.same(b, a, [&] {
      const std::size_t patches = before.patches.size();
      const std::string what = g < patches ? fmt::format("patch {}", before.patches[g].key)
                                           : std::string(g == patches ? "hull" : "feature edges");
      return fmt::format("{}: Euler characteristic {} and {} pieces before, {} and {} after", what, b.euler,
                         b.components, a.euler, a.components);
    });
  }
}

}  // namespace

EndCheckReport compare(const Invariants& before, const Invariants& after, const EndCheckLimits& limits) {
  EndCheckReport report;
  Judge judge(limits, report);
  judge.same(std::int64_t{0}, after.nonpositive_tets,
             [&] { return fmt::format("{} tetrahedra are not positive", after.nonpositive_tets); });
  judge.same(before.shapes.size(), after.shapes.size(), [] { return std::string("the list of patches is another"); });
  judge.same(before.regions.size(), after.regions.size(),
             [&] { return fmt::format("regions: {} before, {} after", before.regions.size(), after.regions.size()); });
  // A flat patch is flat to rounding only, and a volume takes that along its whole area.
  const double slack = limits.rounding * before.size;
  judge.near(before.regions, after.regions, slack, "volume of region");
  judge.near(before.patches, after.patches, 0, "area of patch");
  judge.near(before.lines, after.lines, 0, "length of feature edges (256 * reference + class)");
  double volume = 0;
  for (const Extent& r : after.regions) volume += r.value;
  judge.near(after.hull_volume, volume, limits.rounding * after.size, false,
             "volume inside the hull (before) and of the tetrahedra (after)");
  judge_shapes(before, after, judge);
  judge.roll(before.corners, after.corners, "corners");
  judge.roll(before.required_verts, after.required_verts, "required vertices");
  judge.roll(before.required_edges, after.required_edges, "required edges");
  judge.roll(before.required_triangles, after.required_triangles, "required triangles");
  judge.roll(before.required_tets, after.required_tets, "required tetrahedra");
  return report;
}

std::string to_line(const EndCheckReport& report) {
  constexpr std::size_t kShown = 5;
  std::string line;
  for (std::size_t i = 0; i < std::min(kShown, report.faults.size()); ++i) {
    line += (i == 0 ? "" : "; ") + report.faults[i];
  }
  if (report.faults.size() > kShown) line += fmt::format("; and {} more", report.faults.size() - kShown);
  return line;
}

Json to_json(const EndCheckReport& r) {
  return {{"passed", r.passed()},
          {"compared", r.compared},
          {"largest_difference", r.largest_exact},
          {"largest_difference_curved", r.largest_curved},
          {"faults", r.faults}};
}

}  // namespace skein
