// The hull in distribute(): refuses meshes that are not conforming, not merged, or overlap.
#include <utility>

#include "dist/distribute_steps.hpp"
#include "dist/hull_contact.hpp"

namespace skein::distributing {
namespace {

std::vector<HullFace> hull_of(const Growing& g) {
  const TetMesh& m = g.dist.mesh;
  std::vector<HullFace> out;
  out.reserve(g.speakers.size());
  for (const FaceId f : g.speakers) {  // every face of the hull is one
    if (!is_hull(m.tag(f))) continue;
    HullFace h;
    const auto v = m.verts(f);
    for (std::size_t k = 0; k < 3; ++k) {
      h.gid[k] = g.dist.vert2gid[v[k]];
      h.x[k] = m.coords[v[k]];
    }
    h.tet = g.tet_number[face_tet(f)];
    for (const VertId w : m.tet2vert[face_tet(f)]) h.inside += 0.25 * m.coords[w];
    h.listed = tag_patch(m.tag(f)) != g.bare_hull_patch ? 1 : 0;
    out.push_back(h);
  }
  return out;
}

struct Words {
  const char* what;
  const char* advice;
};
constexpr std::array<Words, kHullFaultKinds> kWords{{
    {"vertices inside a face or an edge of another tetrahedron",
     "the mesh is not conforming there: remesh it so that "
     "faces match"},
    {"pairs of tetrahedra whose faces cover each other without being the same face",
     "the mesh is not conforming there: both sides need the same triangles"},
    {"pairs of tetrahedra that overlap", "remove or repair them"},
    {"pairs of vertices at the same place whose tetrahedra are not connected",
     "merge them with --merge TOL, or list the triangles of both sides if it is a crack"},
    {"tetrahedra inside other tetrahedra", "remove the part of the mesh that is too much"},
}};

void refuse_all(const FileSource& src, const std::vector<HullFault>& faults) {
  if (src.comm.sum(static_cast<std::int64_t>(faults.size())) == 0) return;
  for (std::size_t kind = 0; kind < kHullFaultKinds; ++kind) {
    std::vector<Offence> offences;
    for (const HullFault& f : faults) {
      if (static_cast<std::size_t>(f.kind) == kind) offences.push_back({f.number, f.other, f.verts});
    }
    refuse(src, std::move(offences), kWords[kind].what, kWords[kind].advice);
  }
}

}  // namespace

void check_hull(const FileSource& src, const Growing& g, DistributeReport& report) {
  const std::vector<HullFace> hull = hull_of(g);
  const HullContacts contacts = find_hull_contacts(src.comm, hull);
  refuse_all(src, contacts.faults);
  refuse_all(src, find_nested(src.comm, hull));
  report.crack_verts = contacts.crack_verts;
}

}  // namespace skein::distributing
