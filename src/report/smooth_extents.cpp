// How much area, length and volume the curved surface has more than the facets.
#include <algorithm>

#include "report/invariants.hpp"

namespace skein {
namespace {

Extent* find(std::vector<Extent>& list, std::int64_t key) {
  const auto at =
      std::lower_bound(list.begin(), list.end(), key, [](const Extent& e, std::int64_t k) { return e.key < k; });
  return at != list.end() && at->key == key ? &*at : nullptr;
}

/// The same triangle, turned over.
bool is_turned(const SurfaceInput::Triangle& a, const SurfaceInput::Triangle& b) {
  const auto at = std::find(b.begin(), b.end(), a[0]) - b.begin();
  return b[static_cast<std::size_t>(at + 1) % 3] != a[1];
}

}  // namespace

void add_smooth(Invariants& before, const TetMesh& mesh, const BoundarySurface& boundary,
                const ReferenceSurface& surface) {
  const SurfaceInput& in = surface.input();
  for (std::size_t t = 0; t < in.triangles.size(); ++t) {
    const auto gain = surface.gain(static_cast<std::int32_t>(t));
    if (Extent* patch = find(before.patches, mesh.patch_ref[static_cast<std::size_t>(in.patch[t])]))
      patch->smooth += gain.area;
    const double out = is_turned(boundary.input.triangles[t], in.triangles[t]) ? -gain.volume : gain.volume;
    const BoundarySurface::Sides& sides = boundary.sides[t];
    if (Extent* region = find(before.regions, sides.behind)) region->smooth += out;
    if (sides.has_before == 0) continue;
    if (Extent* region = find(before.regions, sides.before)) region->smooth -= out;
  }
  for (std::size_t e = 0; e < in.edges.size(); ++e) {
    Extent* line = find(before.lines, boundary.edge_key[e]);
    const auto edge = static_cast<std::int32_t>(e);
    if (line != nullptr) line->smooth += surface.edge_length(edge) - surface.chord(edge);
  }
}

void expect_smooth(Invariants& before, const Invariants& of_original) {
  const auto expect = [](std::vector<Extent>& list, const std::vector<Extent>& wanted) {
    for (const Extent& w : wanted) {
      if (Extent* e = find(list, w.key)) e->smooth = w.value + w.smooth - e->value;
    }
  };
  expect(before.regions, of_original.regions);
  expect(before.patches, of_original.patches);
  expect(before.lines, of_original.lines);
}

}  // namespace skein
