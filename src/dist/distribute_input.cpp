// First steps of distribute(): checks of the slices, and tetrahedra to their ranks with their vertices.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/hilbert.hpp"
#include "dist/distribute_steps.hpp"
#include "mesh/predicates.hpp"
#include "metric/complexity.hpp"
#include "partition/hilbert.hpp"

namespace skein::distributing {

namespace {

void check_fields(const FileSource& src) {
  agree(src.comm, [&] {
    const FieldSlice* f = src.fields;
    if (f == nullptr) return;
    if (f->total != src.file.total_verts)
      throw Error(ExitCode::kInput, fmt::format("{}: values at {} vertices, but {} has {}", f->path, f->total,
                                                src.file.path, src.file.total_verts));
    if (f->first != src.file.first_vert ||
        f->values.size() != src.file.coords.size() * static_cast<std::size_t>(f->width))
      throw Error(ExitCode::kInternal, "distribute: the slices of mesh and fields differ");
  });
}

template <std::size_t N>
void check_entities(const FileSource& src, const EntitySlice<N>& list, const std::string& name, bool all_differ) {
  std::vector<Offence> outside, repeated;
  for (std::size_t i = 0; i < list.verts.size(); ++i) {
    const auto& v = list.verts[i];
    bool in = true, twice = false;
    for (std::size_t a = 0; a < N; ++a) {
      in = in && num(v[a]) >= 0 && num(v[a]) < src.file.total_verts;
      for (std::size_t b = 0; b < a; ++b) twice = twice || v[a] == v[b];
    }
    if (in && !(twice && all_differ)) continue;
    Offence o{list.first + static_cast<std::int64_t>(i), -1, {kNoGlobal, kNoGlobal, kNoGlobal, kNoGlobal}};
    std::copy_n(v.begin(), N, o.verts.begin());
    (in ? repeated : outside).push_back(o);
  }
  refuse(src, outside, name + " with a vertex number that is not in the mesh", "check how it was made");
  refuse(src, repeated, name + " with a repeated vertex", "remove them");
}

void check_coordinates(const FileSource& src) {
  std::vector<Offence> bad;
  for (std::size_t i = 0; i < src.file.coords.size(); ++i) {
    if (!is_finite(src.file.coords[i])) bad.push_back({src.file.first_vert + static_cast<std::int64_t>(i), -1});
  }
  refuse(src, bad, "vertices whose coordinates are not finite", "check how the mesh was made");
}

/// A mark for one item of a list that another rank may own.
template <class Bits>
struct Mark {
  std::int64_t item;
  Bits bits;
};

/// Collective. The marks, joined, of the local items first .. first + n - 1.
template <class Bits>
std::vector<Bits> deliver_marks(const Comm& comm, const Blocks& blocks, std::int64_t first, std::size_t n,
                                const std::vector<Mark<Bits>>& marks) {
  std::vector<Rank> dest(marks.size());
  std::vector<std::int64_t> items(marks.size());
  for (std::size_t i = 0; i < marks.size(); ++i) {
    dest[i] = blocks.owner(marks[i].item);
    items[i] = marks[i].item << 8 | static_cast<std::int64_t>(marks[i].bits);
  }
  std::vector<Bits> out(n, Bits{});
  for (const std::int64_t m : exchange_items(comm, dest, items).items) {
    const auto at = static_cast<std::size_t>((m >> 8) - first);
    if (at < n) out[at] = static_cast<Bits>(static_cast<std::int64_t>(out[at]) | (m & 0xff));
  }
  return out;
}

/// Collective. The same for the entities of a list.
template <std::size_t N, class Bits>
std::vector<Bits> deliver_marks_of(const Comm& comm, const EntitySlice<N>& list, const std::vector<Mark<Bits>>& marks) {
  return deliver_marks(comm, Blocks(comm, list.first), list.first, list.verts.size(), marks);
}

template <class Bits>
void mark_list(const VertexListSlice& list, std::int64_t total, Bits bits, std::vector<Mark<Bits>>& marks) {
  for (const GlobalId g : list.verts) {
    if (num(g) >= 0 && num(g) < total) marks.push_back({num(g), bits});
  }
}

void deliver_vertex_classes(FileSource& src) {
  const MeshSlice& f = src.file;
  std::vector<Mark<VertClass>> marks;
  mark_list(f.corners, f.total_verts, kCorner, marks);
  mark_list(f.required_verts, f.total_verts, kRequired, marks);
  for (const auto& tri : f.triangles.verts) {
    for (const GlobalId v : tri) marks.push_back({num(v), kSurface});
  }
  for (std::size_t i = 0; i < f.edges.verts.size(); ++i) {
    const VertClass bits = any(src.edge_class[i] & kRequiredEdge) ? kRidge | kFixed : kRidge;
    for (const GlobalId v : f.edges.verts[i]) marks.push_back({num(v), bits});
  }
  src.vert_class = deliver_marks(src.comm, src.vert_blocks, f.first_vert, f.coords.size(), marks);
}

}  // namespace

FileSource open_source(const Comm& comm, const MeshSlice& file, const FieldSlice* fields,
                       const DistributeOptions& options) {
  FileSource src{comm, file, fields, options, Blocks(comm, file.first_vert), {}, {}, {}, {}, {}};
  check_fields(src);
  check_coordinates(src);
  check_entities(src, file.tets, "tetrahedra", true);
  check_entities(src, file.triangles, "triangles", true);
  check_entities(src, file.edges, "edges", false);
  std::vector<Mark<FeatureClass>> edges;
  mark_list(file.ridges, file.edges.total, kRidgeEdge, edges);
  mark_list(file.required_edges, file.edges.total, kRequiredEdge, edges);
  src.edge_class = deliver_marks_of(comm, file.edges, edges);
  std::vector<Mark<std::uint8_t>> triangles;
  mark_list(file.required_triangles, file.triangles.total, std::uint8_t{1}, triangles);
  src.triangle_required = deliver_marks_of(comm, file.triangles, triangles);
  std::vector<Mark<TetClass>> tets;
  mark_list(file.required_tets, file.tets.total, kRequiredTet, tets);
  src.tet_class = deliver_marks_of(comm, file.tets, tets);
  deliver_vertex_classes(src);
  return src;
}

std::int64_t count_double_edges(const FileSource& src) {
  using Edge = std::array<GlobalId, 2>;
  std::vector<Edge> edges = src.file.edges.verts;
  std::vector<Rank> dest;
  dest.reserve(edges.size());
  for (Edge& e : edges) {
    if (e[1] < e[0]) std::swap(e[0], e[1]);
    dest.push_back(meeting_rank(hash_of(e), src.comm.size()));
  }
  edges = exchange_items(src.comm, dest, edges).items;
  std::sort(edges.begin(), edges.end());
  return src.comm.sum(static_cast<std::int64_t>(edges.end() - std::unique(edges.begin(), edges.end())));
}

namespace {

struct FileTet {
  std::array<GlobalId, 4> verts;
  std::uint64_t key;
  std::int64_t number;
  std::int32_t ref;
  TetClass tet_class;
  std::array<std::uint8_t, 3> unused;
};

Inquiry<GlobalId> ask_vertices(const FileSource& src, const std::vector<GlobalId>& gids) {
  std::vector<Rank> dest(gids.size());
  for (std::size_t i = 0; i < gids.size(); ++i) dest[i] = src.vert_blocks.owner(num(gids[i]));
  return {src.comm, dest, gids};
}
std::size_t local(const FileSource& src, GlobalId g) noexcept {
  return static_cast<std::size_t>(num(g) - src.file.first_vert);
}

/// The first numbers of the fields are the log-metric.
bool has_metric(const FileSource& src) noexcept { return src.options.metric_first && src.fields != nullptr; }

/// A vertex as a tetrahedron's destination depends on it.
struct Site {
  Vec3 x;
  double half_trace;  ///< of the log-metric
};

/// Removes the tetrahedra that are given again.
void leave_out_dropped(const FileSource& src, std::vector<FileTet>& tets, std::vector<Rank>& dest) {
  if (src.tet_dropped.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tets.size(); ++i) {
    if (src.tet_dropped[i] != 0) continue;
    tets[kept] = tets[i];
    dest[kept++] = dest[i];
  }
  tets.resize(kept);
  dest.resize(kept);
}

/// The slice's tetrahedra with their Hilbert keys, and the rank of each.
std::vector<FileTet> plan(const FileSource& src, std::vector<Rank>& dest) {
  const auto& tets = src.file.tets;
  const bool metric = src.options.work_from_metric && has_metric(src);
  GidMap gids(tets.verts.size() / 4 + 16, src.file.total_verts);
  std::vector<std::array<VertId, 4>> verts(tets.verts.size());
  for (std::size_t i = 0; i < verts.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) verts[i][k] = gids.insert(tets.verts[i][k]);
  }
  const auto inquiry = ask_vertices(src, gids.gids());
  std::vector<Site> answers;
  answers.reserve(inquiry.asked().items.size());
  for (const GlobalId g : inquiry.asked().items) {
    const std::size_t v = local(src, g);
    const double* l = metric ? src.fields->values.data() + v * static_cast<std::size_t>(src.fields->width) : nullptr;
    answers.push_back({src.file.coords[v], metric ? 0.5 * (l[0] + l[2] + l[5]) : 0});
  }
  const auto sites = inquiry.answer(answers);
  const Box box = global_box(src.comm, src.file.coords);
  std::vector<Vec3> centre(verts.size());
  std::vector<double> work(verts.size(), 1.0);
  for (std::size_t i = 0; i < verts.size(); ++i) {
    std::array<Site, 4> s;
    for (std::size_t k = 0; k < 4; ++k) s[k] = sites[idx(verts[i][k])];
    centre[i] = 0.25 * (s[0].x + s[1].x + s[2].x + s[3].x);
    if (metric) {  // about predicted_elements()
      const double mean = centroid_rule({s[0].half_trace, s[1].half_trace, s[2].half_trace, s[3].half_trace});
      const double w = tets_of_unit_mesh(mean, volume6(s[0].x, s[1].x, s[2].x, s[3].x));
      if (std::isfinite(w)) work[i] += w;
    }
  }
  std::vector<std::uint64_t> keys(verts.size());
  hilbert_keys(centre, box, keys);
  const auto part = cut_keys(src.comm, keys, work, src.comm.size());
  dest.resize(part.size());
  std::transform(part.begin(), part.end(), dest.begin(), rank_of);
  centre = {}, work = {};  // before the largest array is made
  std::vector<FileTet> out(verts.size());
  for (std::size_t i = 0; i < verts.size(); ++i) {
    out[i] = {tets.verts[i], keys[i], tets.first + static_cast<std::int64_t>(i), tets.ref[i], src.tet_class[i], {}};
  }
  leave_out_dropped(src, out, dest);
  return out;
}

/// Sends the tetrahedra and makes a mesh of what comes, in Hilbert order, without vertex values.
Growing gather_tets(const FileSource& src) {
  Packets<FileTet> got;
  {
    std::vector<Rank> dest;
    auto tets = plan(src, dest);
    got = exchange(src.comm, pack(std::span<const Rank>(dest), std::move(tets)));
  }
  std::vector<KeyIndex> order(got.items.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = {got.items[i].key, static_cast<std::uint32_t>(i)};
  radix_sort(order);
  Growing g;
  TetMesh& m = g.dist.mesh;
  g.gid2vert = GidMap(order.size() / 4 + 16, src.file.total_verts);
  m.tet2vert.resize(order.size());
  m.tet_ref.resize(order.size());
  m.tet_class.resize(order.size());
  g.tet_number.resize(order.size());
  for (const TetId t : IdRange<TetId>(order.size())) {
    const FileTet& in = got.items[order[idx(t)].index];
    for (std::size_t k = 0; k < 4; ++k) m.tet2vert[t][k] = g.gid2vert.insert(in.verts[k]);
    m.tet_ref[t] = in.ref;
    m.tet_class[t] = in.tet_class;
    g.tet_number[t] = in.number;
  }
  return g;
}

struct FileVert {
  Vec3 x;
  std::int32_t ref;
  VertClass vert_class;
  std::uint8_t many;
  std::uint16_t unused;
};

/// Collective. The numbers of the fields at the vertices asked for.
std::vector<double> fetch_fields(const FileSource& src, const Inquiry<GlobalId>& inquiry) {
  const auto& asked = inquiry.asked().items;
  const auto width = static_cast<std::size_t>(src.fields->width);
  std::vector<double> values(asked.size() * width);
  for (std::size_t i = 0; i < asked.size(); ++i)
    std::copy_n(src.fields->values.data() + local(src, asked[i]) * width, width, values.data() + i * width);
  return inquiry.answer(values, width);
}

/// Shares them out among the columns.
void set_fields(const FileSource& src, TetMesh& m, std::vector<double> values) {
  if (!has_metric(src)) {
    m.fields = {src.fields->width, std::move(values)};
    return;
  }
  const auto width = static_cast<std::size_t>(src.fields->width);
  m.log_metric.resize(m.vert_slots());
  m.fields.width = src.fields->width - 6;
  m.fields.values.reserve(values.size() - 6 * m.vert_slots());
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const double* l = values.data() + idx(v) * width;
    m.log_metric[v] = {l[0], l[1], l[2], l[3], l[4], l[5]};
    m.fields.values.insert(m.fields.values.end(), l + 6, l + width);
  }
}

void fetch_vertices(const FileSource& src, Growing& g, DistributeReport& report) {
  const auto inquiry = ask_vertices(src, g.gid2vert.gids());
  const auto& asked = inquiry.asked().items;
  std::vector<std::uint8_t> asks(src.file.coords.size(), 0);
  for (const GlobalId a : asked) asks[local(src, a)] = asks[local(src, a)] == 0 ? 1 : 2;
  report.unused_verts = src.comm.sum(static_cast<std::int64_t>(std::count(asks.begin(), asks.end(), 0)));
  std::vector<FileVert> answers;
  answers.reserve(asked.size());
  for (const GlobalId a : asked) {
    const std::size_t v = local(src, a);
    const auto many = static_cast<std::uint8_t>(asks[v] > 1 ? 1 : 0);
    answers.push_back({src.file.coords[v], src.file.vert_ref[v], src.vert_class[v], many, 0});
  }
  const auto verts = inquiry.answer(answers);
  TetMesh& m = g.dist.mesh;
  m.coords.resize(verts.size());
  m.vert_ref.resize(verts.size());
  m.vert_class.resize(verts.size());
  m.vert_state.resize(verts.size());
  g.many.resize(verts.size());
  for (const VertId v : IdRange<VertId>(verts.size())) {
    const FileVert& in = verts[idx(v)];
    m.coords[v] = in.x;
    m.vert_ref[v] = in.ref;
    m.vert_class[v] = in.vert_class;
    g.many[v] = in.many;
  }
  g.dist.vert2gid = IdVector<VertId, GlobalId>(g.gid2vert.gids());
  if (src.fields != nullptr) set_fields(src, m, fetch_fields(src, inquiry));
}

/// Turns tetrahedra of negative volume: the order of their vertices carries no meaning. Refuses flat ones.
void orient_tets(const FileSource& src, Growing& g, DistributeReport& report) {
  TetMesh& m = g.dist.mesh;
  std::int64_t turned = 0;
  std::vector<Offence> flat;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    auto& v = m.tet2vert[t];
    const int sign = orient3d_sign(m.coords[v[0]], m.coords[v[1]], m.coords[v[2]], m.coords[v[3]]);
    if (sign > 0) continue;
    const auto& gid = g.dist.vert2gid;
    if (sign == 0) flat.push_back({g.tet_number[t], -1, {gid[v[0]], gid[v[1]], gid[v[2]], gid[v[3]]}});
    std::swap(v[0], v[1]);
    ++turned;
  }
  refuse(src, flat, "flat tetrahedra (their volume is zero)", "repair the mesh there");
  report.turned_tets = src.comm.sum(turned);
}

}  // namespace

Growing place_tets(const FileSource& src, DistributeReport& report) {
  Growing g = gather_tets(src);
  fetch_vertices(src, g, report);
  orient_tets(src, g, report);
  return g;
}

}  // namespace skein::distributing
