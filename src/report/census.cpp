// Sums by reference, and the few worst elements of all ranks.
#include "report/census.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "base/text.hpp"
#include "metric/batch.hpp"
#include "metric/measure.hpp"

namespace skein {
namespace {

/// Counts of triangles between tetrahedra are halves, one from each side.
struct Sums {
  std::vector<std::int32_t> ref;
  std::vector<double> value;  // per reference: count, size
};

/// Collective. The rows of all ranks, added up by reference.
std::vector<CensusRow> add_up(const Comm& comm, const Sums& mine) {
  const std::vector<std::int32_t> ref = comm.all_gather(mine.ref);
  const std::vector<double> value = comm.all_gather(mine.value);
  std::vector<std::size_t> order(ref.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ref[a] < ref[b]; });
  std::vector<CensusRow> rows;
  double count = 0;
  for (const std::size_t i : order) {
    if (rows.empty() || rows.back().ref != ref[i]) rows.push_back({ref[i], 0, 0}), count = 0;
    count += value[2 * i];
    rows.back().count = std::llround(count);
    rows.back().size += value[2 * i + 1];
  }
  std::erase_if(rows, [](const CensusRow& r) { return r.count == 0; });
  return rows;
}

double area(const TetMesh& m, FaceId f) noexcept {
  const auto v = m.verts(f);
  return 0.5 * norm(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
}

Json rows_json(const std::vector<CensusRow>& before, const std::vector<CensusRow>& after, const char* size) {
  Json list = Json::array();
  const auto find = [](const std::vector<CensusRow>& rows, std::int32_t ref) {
    const auto at = std::ranges::find(rows, ref, &CensusRow::ref);
    return at == rows.end() ? CensusRow{ref, 0, 0} : *at;
  };
  for (const CensusRow& a : after) {
    const CensusRow b = find(before, a.ref);
    list.push_back({{"ref", a.ref},
                    {"elements_in", b.count},
                    {"elements_out", a.count},
                    {std::string(size) + "_in", b.size},
                    {std::string(size) + "_out", a.size}});
  }
  return list;
}

void add_lines(const std::vector<CensusRow>& before, const std::vector<CensusRow>& after, const char* what,
               const char* size, std::vector<std::string>& lines) {
  constexpr std::size_t kShown = 12;
  for (std::size_t i = 0; i < after.size() && i < kShown; ++i) {
    const auto b = std::ranges::find(before, after[i].ref, &CensusRow::ref);
    if (b == before.end()) continue;
    const double change = b->size > 0 ? 100 * (after[i].size / b->size - 1) : 0;
    lines.push_back(fmt::format("  {} {:<6} {:>13} -> {:>13}  {} {:.6g}{}", what, after[i].ref, grouped(b->count),
                                grouped(after[i].count), size, after[i].size,
                                std::abs(change) < 1e-7 ? "" : fmt::format(" ({:+.2g} %)", change)));
  }
  if (after.size() > kShown) lines.push_back(fmt::format("  ... {} in all", after.size()));
}

std::string counts_text(const std::vector<CensusRow>& rows, const char* one, const char* many) {
  constexpr std::size_t kShown = 8;
  std::string text = fmt::format("{} {}", rows.size(), rows.size() == 1 ? one : many);
  for (std::size_t i = 0; i < rows.size() && i < kShown; ++i) {
    text += fmt::format("{}{}: {}", i == 0 ? " (" : ", ", rows[i].ref, grouped(rows[i].count));
  }
  if (!rows.empty()) text += rows.size() > kShown ? ", ...)" : ")";
  return text;
}

/// The least and the largest dihedral angle, degrees.
std::pair<double, double> dihedrals(const TetMesh& m, TetId t) noexcept {
  double low = 180, high = 0;
  std::array<Vec3, 4> n;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto v = m.verts(make_face(t, k));
    n[k] = normalized(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
  }
  for (const auto& [a, b] : kEdgeVerts) {
    const double angle = 180 - 180 / std::numbers::pi * std::acos(std::clamp(dot(n[a], n[b]), -1.0, 1.0));
    low = std::min(low, angle), high = std::max(high, angle);
  }
  return {low, high};
}

WorstTet describe(const DistMesh& dist, TetId t, double quality) {
  const TetMesh& m = dist.mesh;
  WorstTet w;
  w.quality = quality, w.region = m.tet_ref[t];
  for (std::size_t k = 0; k < 4; ++k) {
    const VertId v = m.tet2vert[t][k];
    w.at = w.at + 0.25 * m.coords[v];
    w.verts[k] = dist.vert2gid[v];
    ++w.bound[m.has(v, kStays) ? 0 : m.has(v, kRidge) ? 1 : m.has(v, kSurface) ? 2 : 3];
    const FaceTag tag = m.face_tag[t][k];
    if (tag != 0 && w.faces++ == 0) w.patch = m.patch_ref[static_cast<std::size_t>(tag_patch(tag))];
  }
  std::sort(w.verts.begin(), w.verts.end());
  std::tie(w.min_dihedral, w.max_dihedral) = dihedrals(m, t);
  return w;
}

bool worse(const WorstTet& a, const WorstTet& b) noexcept {
  return a.quality != b.quality ? a.quality < b.quality : a.verts < b.verts;
}

}  // namespace

Census census(const Comm& comm, const DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  Sums patches{m.patch_ref, std::vector<double>(2 * m.patch_ref.size(), 0)}, regions;
  std::size_t at = 0;  // of the last region, which is mostly that of the next tetrahedron, too
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (at >= regions.ref.size() || regions.ref[at] != m.tet_ref[t])
      at = static_cast<std::size_t>(std::ranges::find(regions.ref, m.tet_ref[t]) - regions.ref.begin());
    if (at == regions.ref.size()) regions.ref.push_back(m.tet_ref[t]), regions.value.resize(2 * at + 2, 0);
    regions.value[2 * at] += 1, regions.value[2 * at + 1] += volume6(m, t) / 6;
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceTag tag = m.face_tag[t][k];
      if (tag == 0) continue;
      const double share = is_hull(tag) ? 1 : 0.5;
      double* const s = patches.value.data() + 2 * static_cast<std::size_t>(tag_patch(tag));
      s[0] += share, s[1] += share * area(m, make_face(t, k));
    }
  }
  return {add_up(comm, patches), add_up(comm, regions)};
}

Json to_json(const Census& before, const Census& after) {
  return {{"patches", rows_json(before.patches, after.patches, "area")},
          {"regions", rows_json(before.regions, after.regions, "volume")}};
}

std::vector<std::string> to_lines(const Census& before, const Census& after) {
  std::vector<std::string> lines;
  add_lines(before.regions, after.regions, "region", "volume", lines);
  add_lines(before.patches, after.patches, "patch ", "area", lines);
  return lines;
}

std::string to_line(const Census& now) {
  return fmt::format("{}; {}", counts_text(now.regions, "region", "regions"),
                     counts_text(now.patches, "patch", "patches"));
}

std::vector<WorstTet> worst_tets(const Comm& comm, const DistMesh& dist, std::size_t n, Measure measure) {
  const TetMesh& m = dist.mesh;
  IdVector<VertId, VertMetric> at(m.vert_slots(), vert_metric(isotropic(1)));
  if (measure == Measure::kInMetric) {
    vert_metrics_from_logs(
        0, at.size(), [&](std::size_t i) -> const SymTensor& { return m.log_metric[to_id<VertId>(i)]; },
        [&](std::size_t i, const VertMetric& metric) { at[to_id<VertId>(i)] = metric; });
  }
  std::vector<std::pair<double, TetId>> few;  // a heap, the best of them in front
  for (const TetId t : IdRange<TetId>(n > 0 ? m.tet_slots() : 0)) {
    const auto& v = m.tet2vert[t];
    const double q3 = quality_cubed(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]], at[v[0]], at[v[1]],
                                    at[v[2]], at[v[3]]);
    if (few.size() == n && !(q3 < few.front().first)) continue;
    if (few.size() == n) std::pop_heap(few.begin(), few.end()), few.pop_back();
    few.emplace_back(q3, t);
    std::push_heap(few.begin(), few.end());
  }
  std::vector<WorstTet> mine;
  for (const auto& [q3, t] : few) mine.push_back(describe(dist, t, quality(q3)));
  std::vector<WorstTet> worst = comm.all_gather(mine);
  std::sort(worst.begin(), worst.end(), worse);
  if (worst.size() > n) worst.resize(n);
  return worst;
}

std::string to_line(const WorstTet& t) {
  constexpr std::array<const char*, 4> kBound{"fixed", "on ridges", "on the surface", "inside"};
  std::string bound;
  for (std::size_t i = 0; i < 4; ++i) {
    if (t.bound[i] > 0) bound += fmt::format("{}{} {}", bound.empty() ? "" : ", ", t.bound[i], kBound[i]);
  }
  return fmt::format(
      "quality {:.3f} at ({:.6g}, {:.6g}, {:.6g}), dihedral angles {:.1f} to {:.1f}, region {}{}; its vertices: {}",
      t.quality, t.at.x, t.at.y, t.at.z, t.min_dihedral, t.max_dihedral, t.region,
      t.faces > 0 ? fmt::format(", {} face{} on patch {}", t.faces, t.faces == 1 ? "" : "s", t.patch) : "", bound);
}

Json to_json(const WorstTet& t) {
  Json j{{"quality", t.quality},
         {"at", {t.at.x, t.at.y, t.at.z}},
         {"min_dihedral", t.min_dihedral},
         {"max_dihedral", t.max_dihedral},
         {"region", t.region},
         {"vertices_fixed", t.bound[0]},
         {"vertices_on_ridges", t.bound[1]},
         {"vertices_on_surface", t.bound[2]},
         {"vertices_inside", t.bound[3]}};
  j["patch"] = t.faces > 0 ? Json(t.patch) : Json();
  return j;
}

}  // namespace skein
