// distribute(): the order of its steps, and how it refuses a file.
#include "dist/distribute.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "dist/distribute_steps.hpp"
#include "dist/sharing.hpp"

namespace skein {
namespace distributing {

void refuse(const FileSource& src, std::vector<Offence> offences, const std::string& what, const std::string& advice) {
  constexpr std::size_t kNamed = 5;
  const auto total = src.comm.sum(static_cast<std::int64_t>(offences.size()));
  if (total == 0) return;
  const auto by_number = [](const Offence& a, const Offence& b) {
    return std::pair(a.number, a.other) < std::pair(b.number, b.other);
  };
  std::sort(offences.begin(), offences.end(), by_number);
  offences.resize(std::min(offences.size(), kNamed));
  offences = src.comm.all_gather(offences);
  std::sort(offences.begin(), offences.end(), by_number);
  offences.resize(std::min(offences.size(), kNamed));
  // The first one's coordinates, from the owners of its vertices (the others add zero).
  std::array<double, 12> x{};
  const auto last = src.file.first_vert + std::ssize(src.file.coords);
  for (std::size_t k = 0; k < 4; ++k) {
    const std::int64_t v = num(offences[0].verts[k]);
    if (v < src.file.first_vert || v >= last) continue;
    const Vec3 p = src.file.coords[v - src.file.first_vert];
    x[3 * k] = p.x;
    x[3 * k + 1] = p.y;
    x[3 * k + 2] = p.z;
  }
  src.comm.reduce(std::span<double>(x), Op::kSum);
  const std::int64_t base = src.file.first_number;
  std::string list, where;
  for (const auto& o : offences) {
    list += fmt::format("{}{}", list.empty() ? "" : ", ", o.number + base);
    if (o.other >= 0) list += fmt::format(" and {}", o.other + base);
  }
  if (total > std::ssize(offences)) list += ", ...";
  for (std::size_t k = 0; k < 4; ++k) {
    const std::int64_t v = num(offences[0].verts[k]);
    if (v >= 0 && v < src.file.total_verts)
      where += fmt::format(" {} ({:.7g}, {:.7g}, {:.7g})", v + base, x[3 * k], x[3 * k + 1], x[3 * k + 2]);
  }
  if (!where.empty()) where = ", the first with vertices" + where;
  throw Error(ExitCode::kInvalidMesh,
              fmt::format("{}: {}: {} ({} in all){}; {}", src.file.path, what, list, total, where, advice));
}

}  // namespace distributing

DistMesh distribute(const Comm& comm, const MeshSlice& file, const FieldSlice* fields, const DistributeOptions& options,
                    DistributeReport* report) {
  using namespace distributing;
  DistributeReport found;
  FileSource src = open_source(comm, file, fields, options);
  found.double_edges = count_double_edges(src);
  Growing g = place_tets(src, found);
  while (!match_and_tag_faces(src, g, found)) g = place_tets(src, found);
  if (options.check_hull) check_hull(src, g, found);
  rebuild_sharing(comm, g.dist);
  std::vector<Offence> overlapping;  // a closed star here, and more tetrahedra at the vertex elsewhere
  for (const VertId v : IdRange<VertId>(g.many.size())) {
    if (g.many[v] == 0 || g.dist.mesh.has(v, kFrozen)) continue;
    overlapping.push_back({num(g.dist.vert2gid[v]), -1, {g.dist.vert2gid[v], kNoGlobal, kNoGlobal, kNoGlobal}});
  }
  refuse(src, overlapping, "vertices with overlapping tetrahedra", "remove the tetrahedra that are too many");
  merge_vertex_flags(comm, g.dist);
  find_features(src, g, found);
  count_global(comm, g.dist);
  if (report != nullptr) *report = found;
  return std::move(g.dist);
}

}  // namespace skein
