// The search for contacts in the hull, on slices of a file.
#include "report/check_hull.hpp"

#include <algorithm>
#include <utility>

#include "dist/hull_contact.hpp"
#include "report/slice_coordinates.hpp"

namespace skein {
namespace {

/// Collective. The faces with their coordinates.
std::vector<HullFace> located(const Comm& comm, const MeshSlice& mesh, const std::vector<LoneFace>& lone) {
  std::vector<std::array<GlobalId, 4>> verts;
  for (const LoneFace& f : lone) verts.push_back(f.verts);
  const SliceCoordinates x(comm, mesh, verts, nullptr);
  std::vector<HullFace> out;
  for (const LoneFace& f : lone) {
    HullFace h;
    h.gid = {f.verts[0], f.verts[1], f.verts[2]};
    if (f.odd != 0) std::swap(h.gid[1], h.gid[2]);
    for (std::size_t k = 0; k < 3; ++k) h.x[k] = x[h.gid[k]];
    for (const GlobalId v : f.verts) h.inside += 0.25 * x[v];
    h.tet = f.tet;
    h.listed = f.triangles > 0 ? 1 : 0;
    out.push_back(h);
  }
  return out;
}

Fault fault_of(HullFaultKind kind) noexcept {
  switch (kind) {
    case HullFaultKind::kHanging:
      return Fault::kHangingVertex;
    case HullFaultKind::kCovering:
      return Fault::kCoveringFaces;
    case HullFaultKind::kCrossing:
      return Fault::kCrossingTets;
    case HullFaultKind::kUnmerged:
      return Fault::kUnmergedVertices;
    case HullFaultKind::kNested:
      break;
  }
  return Fault::kNestedTet;
}

}  // namespace

std::vector<Finding> hull_findings(const Comm& comm, const MeshSlice& mesh, const std::vector<LoneFace>& lone,
                                   Nesting nesting, CheckResult& result) {
  const std::vector<HullFace> hull = located(comm, mesh, lone);
  HullContacts contacts = find_hull_contacts(comm, hull);
  result.crack_verts = contacts.crack_verts;
  if (nesting == Nesting::kJudge) {
    const auto nested = find_nested(comm, hull);
    contacts.faults.insert(contacts.faults.end(), nested.begin(), nested.end());
  }
  std::vector<Finding> out;
  for (const HullFault& f : contacts.faults) {
    Finding found;
    found.fault = fault_of(f.kind), found.entity = f.number, found.other = f.other;
    found.corners = f.kind == HullFaultKind::kHanging ? 1 : f.corners;
    found.verts = f.verts;
    out.push_back(found);
  }
  return out;
}

}  // namespace skein
