// The result of a check as text and as JSON. Numbers from 1, as in the file.
#include <fmt/core.h>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "report/check.hpp"

namespace skein {
namespace {

struct Words {
  const char* key;     // of the count in JSON
  const char* text;    // after the count
  const char* entity;  // what `entity` and `other` number
  const char* verb;    // between entity and other
};
constexpr std::array<Words, kFaults> kWords{{
    {"nonpositive_tets", "inverted or flat tetrahedra", "tetrahedron", ""},
    {"degenerate_tets", "tetrahedra that name a vertex twice", "tetrahedron", ""},
    {"duplicate_tets", "duplicate tetrahedra", "tetrahedron", "is the same as"},
    {"faces_over_2", "faces of more than two tetrahedra", "tetrahedron", "and others share it with"},
    {"misoriented_pairs", "pairs of tetrahedra on the same side of their common face", "tetrahedron", "against"},
    {"hull_faces_not_triangles", "hull faces that are not in the list of triangles", "tetrahedron", ""},
    {"triangles_not_faces", "triangles that are no face of a tetrahedron", "triangle", ""},
    {"duplicate_triangles", "duplicate triangles", "triangle", "is the same as"},
    {"open_hull_edges", "open edges of the hull", "", ""},
    {"nonfinite_coordinates", "coordinates that are not finite", "vertex", ""},
    {"hanging_vertices", "vertices inside a face or an edge of another tetrahedron", "vertex", ""},
    {"covering_faces", "pairs of tetrahedra whose faces cover each other without being the same", "tetrahedron", "and"},
    {"crossing_tets", "pairs of tetrahedra that overlap", "tetrahedron", "and"},
    {"unmerged_vertices", "pairs of vertices at the same place whose tetrahedra are not connected", "vertex",
     "is at the place of"},
    {"nested_tets", "tetrahedra inside other tetrahedra", "tetrahedron", ""},
    {"nonmanifold_hull_edges", "edges of more than two hull faces", "", ""},
    {"unused_vertices", "unused vertices", "vertex", ""},
    {"duplicate_vertices", "duplicate vertices", "vertex", "is at the place of"},
}};
const Words& words(Fault f) noexcept { return kWords[static_cast<std::size_t>(f)]; }

std::string line(const Finding& f) {
  const Words& w = words(f.fault);
  std::string text = "    ";
  if (f.entity >= 0) text += fmt::format("{} {}", w.entity, f.entity + 1);
  if (f.other >= 0) text += fmt::format(" {} {} {}", w.verb, w.entity, f.other + 1);
  if (f.corners > 1) {
    text += f.entity < 0                           ? "edge, vertices"
            : f.corners == 3 && w.entity[1] == 'e' ? ", face with vertices"
                                                   : ", vertices";
    for (std::int32_t c = 0; c < f.corners; ++c) text += fmt::format(" {}", num(f.verts[c]) + 1);
  }
  const Vec3 at = f.at();
  text += fmt::format(" at ({:.9g}, {:.9g}, {:.9g})", at.x, at.y, at.z);
  if (f.fault == Fault::kNonpositiveTet) {
    text += fmt::format(", volume {:.4g}", volume6(f.coords[0], f.coords[1], f.coords[2], f.coords[3]) / 6);
  }
  return text + "\n";
}

}  // namespace

Vec3 Finding::at() const noexcept {
  Vec3 sum;
  for (std::int32_t c = 0; c < corners; ++c) sum += coords[c];
  return (1.0 / corners) * sum;
}

const char* key(Fault fault) noexcept { return words(fault).key; }

std::string to_text(const CheckResult& r, const std::string& path) {
  std::string text = fmt::format("{}: {}\n", path, r.valid ? "valid" : "NOT VALID");
  text += fmt::format("  {} vertices, {} tetrahedra, {} triangles, {} hull faces, {} internal triangles\n",
                      grouped(r.vertices), grouped(r.tets), grouped(r.triangles), grouped(r.hull_faces),
                      grouped(r.internal_triangles));
  if (r.surface_only) {
    text += fmt::format("  area {:.12g}, {}\n", r.area,
                        r.volume > 0 ? fmt::format("encloses a volume of {:.12g}", r.volume)
                        : r.oriented ? "not closed"
                                     : "triangles are oriented differently: no enclosed volume");
  }
  if (!r.surface_only)
    text += fmt::format("  volume {:.12g}, smallest tetrahedron {:.4g}, area of the triangles {:.12g}\n", r.volume,
                        r.min_volume, r.area);
  if (r.crack_verts > 0)
    text += fmt::format("  {} pairs of vertices at the same place on matching triangles: a crack\n",
                        grouped(r.crack_verts));
  if (r.tets > 0 && r.triangles == 0) text += "  no triangles: the whole hull becomes one patch\n";
  if (r.vertices == 0 || (r.tets == 0 && r.triangles == 0)) text += "  there is no mesh in this file\n";
  std::size_t at = 0;
  for (std::size_t f = 0; f < kFaults; ++f) {
    if (r.counts[f] == 0) continue;
    text += fmt::format("  {} {}\n", grouped(r.counts[f]), kWords[f].text);
    std::int64_t listed = 0;
    for (; at < r.findings.size() && r.findings[at].fault == static_cast<Fault>(f); ++at, ++listed) {
      text += line(r.findings[at]);
    }
    if (listed == static_cast<std::int64_t>(kMaxFindings) && r.counts[f] > listed) text += "    ...\n";
  }
  return text;
}

Json to_json(const CheckResult& r) {
  Json j{{"valid", r.valid},
         {"vertices", r.vertices},
         {"tets", r.tets},
         {"triangles", r.triangles},
         {"hull_faces", r.hull_faces},
         {"internal_triangles", r.internal_triangles},
         {"hull_euler", r.hull_euler},
         {"crack_vertices", r.crack_verts},
         {"volume", r.volume},
         {"min_volume", r.min_volume},
         {"area", r.area},
         {"surface_only", r.surface_only},
         {"oriented", r.oriented}};
  for (std::size_t f = 0; f < kFaults; ++f) j[kWords[f].key] = r.counts[f];
  Json findings = Json::object();
  for (const Finding& f : r.findings) {
    Json one = Json::object();
    if (f.entity >= 0) one[words(f.fault).entity] = f.entity + 1;
    if (f.other >= 0) one["other"] = f.other + 1;
    Json verts = Json::array();
    for (std::int32_t c = 0; c < f.corners; ++c) verts.push_back(num(f.verts[c]) + 1);
    one["vertices"] = verts;
    const Vec3 at = f.at();
    one["at"] = {at.x, at.y, at.z};
    findings[key(f.fault)].push_back(one);
  }
  j["findings"] = findings;
  return j;
}

}  // namespace skein
