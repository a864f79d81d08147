// Near vertices meet in cells of a grid; each vertex takes the lowest number in its chain; then all is renumbered.
#include "dist/merge_vertices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "base/box.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "dist/blocks.hpp"
#include "dist/rendezvous.hpp"

namespace skein {
namespace {

void require_sound(const Comm& comm, const MeshSlice& mesh) {
  agree(comm, [&] {
    for (std::size_t i = 0; i < mesh.coords.size(); ++i) {
      if (is_finite(mesh.coords[i])) continue;
      throw Error(ExitCode::kInvalidMesh,
                  fmt::format("{}: the coordinates of vertex {} are not finite; check how the mesh was made", mesh.path,
                              mesh.first_vert + static_cast<std::int64_t>(i) + mesh.first_number));
    }
    const auto in_range = [&](const auto& list) {
      for (std::size_t i = 0; i < list.verts.size(); ++i) {
        for (const GlobalId v : list.verts[i]) {
          if (num(v) < 0 || num(v) >= mesh.total_verts)
            throw Error(ExitCode::kInvalidMesh, fmt::format("{}: an entity names vertex {}, of {}", mesh.path,
                                                            num(v) + mesh.first_number, mesh.total_verts));
        }
      }
    };
    in_range(mesh.tets), in_range(mesh.triangles), in_range(mesh.edges);
  });
}

struct Point {
  std::uint64_t key;  ///< of the cell
  Vec3 x;
  GlobalId vert;
};
struct Near {
  GlobalId v, w;
  auto operator<=>(const Near&) const = default;
};

/// The points of this rank in all cells that they may meet others in: cells of twice the distance.
std::vector<Point> spread_points(const MeshSlice& mesh, Vec3 low, double cell, double distance) {
  std::vector<Point> out;
  for (std::size_t i = 0; i < mesh.coords.size(); ++i) {
    const Vec3 x = mesh.coords[i] - low;
    const auto place = [&](double c) { return static_cast<std::int64_t>(std::floor(c / cell)); };
    const GlobalId vert{mesh.first_vert + static_cast<std::int64_t>(i)};
    for (auto c = place(x.x - distance); c <= place(x.x + distance); ++c) {
      for (auto b = place(x.y - distance); b <= place(x.y + distance); ++b) {
        for (auto a = place(x.z - distance); a <= place(x.z + distance); ++a) {
          std::uint64_t key = mix(static_cast<std::uint64_t>(c));
          key = mix(key ^ static_cast<std::uint64_t>(b));
          out.push_back({mix(key ^ static_cast<std::uint64_t>(a)), mesh.coords[i], vert});
        }
      }
    }
  }
  return out;
}

/// Pairs of points of the same cell within the distance, each once on this rank.
std::vector<Near> near_points(std::vector<Point> points, double distance) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return std::tie(a.key, a.x.x, a.vert) < std::tie(b.key, b.x.x, b.vert);
  });
  std::vector<Near> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size() && points[j].key == points[i].key; ++j) {
      if (points[j].x.x - points[i].x.x > distance) break;
      if (points[i].vert == points[j].vert || norm(points[j].x - points[i].x) > distance) continue;
      const auto [v, w] = std::minmax(points[i].vert, points[j].vert);
      out.push_back({v, w});
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// Collective. All pairs of near vertices, each on some rank.
std::vector<Near> find_near(const Comm& comm, const MeshSlice& mesh, double tolerance) {
  const Box own = bounding_box(mesh.coords);
  std::array<double, 6> ends{own.low.x, own.low.y, own.low.z, -own.high.x, -own.high.y, -own.high.z};
  comm.reduce(std::span<double>(ends), Op::kMin);
  const Vec3 low{ends[0], ends[1], ends[2]};
  const double diagonal = norm(Vec3{-ends[3], -ends[4], -ends[5]} - low);
  const double distance = tolerance * diagonal;
  const double cell = std::max(4 * distance, std::max(std::ldexp(diagonal, -40), 1e-300));
  const auto points = spread_points(mesh, low, cell, distance);
  std::vector<Rank> dest;
  for (const Point& p : points) dest.push_back(meeting_rank(p.key, comm.size()));
  return near_points(exchange_items(comm, dest, points).items, distance);
}

/// Which vertex each vertex of this rank becomes: the lowest number that a chain of near vertices leads to.
class Chains {
 public:
  /// Collective.
  Chains(const Comm& comm, const MeshSlice& mesh, const std::vector<Near>& found)
      : comm_(comm), first_(mesh.first_vert), blocks_(comm, mesh.first_vert) {
    std::vector<Near> both;
    std::vector<Rank> dest;
    for (const Near& n : found) {
      both.push_back(n), dest.push_back(blocks_.owner(num(n.v)));
      both.push_back({n.w, n.v}), dest.push_back(blocks_.owner(num(n.w)));
    }
    near_ = exchange_items(comm, dest, both).items;
    lowest.resize(mesh.coords.size());
    for (std::size_t i = 0; i < lowest.size(); ++i) lowest[i] = GlobalId{first_ + static_cast<std::int64_t>(i)};
    while (spread()) {
    }
  }
  std::vector<GlobalId> lowest;

 private:
  /// Collective. True when a vertex has found a lower number anywhere.
  bool spread() {
    std::vector<Near> send;
    std::vector<Rank> dest;
    for (const Near& n : near_) {
      send.push_back({n.w, lowest[num(n.v) - first_]});
      dest.push_back(blocks_.owner(num(n.w)));
    }
    std::int64_t changes = 0;
    for (const Near& n : exchange_items(comm_, dest, send).items) {
      GlobalId& mine = lowest[num(n.v) - first_];
      if (n.w >= mine) continue;
      mine = n.w;
      ++changes;
    }
    return comm_.sum(changes) > 0;
  }
  const Comm& comm_;
  std::int64_t first_;
  Blocks blocks_;
  std::vector<Near> near_;  ///< from vertices of this rank
};

/// New numbers of the items of a list, of which some are gone.
class Renumbering {
 public:
  /// Collective. became[i]: the old number of the item that local item i has become.
  Renumbering(const Comm& comm, std::int64_t first, std::vector<GlobalId> became)
      : comm_(comm), old_first_(first), blocks_(comm, first), number_(std::move(became)) {
    std::int64_t kept = 0;
    for (std::size_t i = 0; i < number_.size(); ++i) {
      stays.push_back(num(number_[i]) == old_first_ + static_cast<std::int64_t>(i) ? 1 : 0);
      kept += stays.back();
    }
    first_number = comm.exclusive_sum(kept);
    total = comm.sum(kept);
    std::int64_t next = first_number;
    std::vector<GlobalId> gone;
    for (std::size_t i = 0; i < number_.size(); ++i) {
      if (stays[i] == 0) gone.push_back(number_[i]);
      if (stays[i] != 0) number_[i] = GlobalId{next++};
    }
    gone = of(gone);
    auto at = gone.begin();
    for (std::size_t i = 0; i < number_.size(); ++i) {
      if (stays[i] == 0) number_[i] = *at++;
    }
  }
  /// Collective. The new numbers of items with these old ones; kNoGlobal for what became nothing.
  [[nodiscard]] std::vector<GlobalId> of(const std::vector<GlobalId>& old) const {
    std::vector<Rank> dest;
    for (const GlobalId g : old) dest.push_back(g == kNoGlobal ? comm_.rank() : blocks_.owner(num(g)));
    const Inquiry<GlobalId> inquiry(comm_, dest, old);
    std::vector<GlobalId> answers;
    for (const GlobalId g : inquiry.asked().items)
      answers.push_back(g == kNoGlobal ? kNoGlobal : number_[num(g) - old_first_]);
    return inquiry.answer(answers);
  }
  std::vector<std::uint8_t> stays;
  std::int64_t total = 0, first_number = 0;

 private:
  const Comm& comm_;
  std::int64_t old_first_;
  Blocks blocks_;
  std::vector<GlobalId> number_;
};

/// Keeps the rows of `width` numbers whose item stays.
template <class T>
void keep_rows(const std::vector<std::uint8_t>& stays, std::size_t width, std::vector<T>& rows) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (stays[i] == 0) continue;
    std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(i * width), width,
                rows.begin() + static_cast<std::ptrdiff_t>(kept * width));
    ++kept;
  }
  rows.resize(kept * width);
}

/// Collective. A list of vertex or entity numbers; numbers whose item is gone go, or become what their item became.
void renumber_list(const Comm& comm, const Renumbering& numbers, VertexListSlice& list) {
  list.verts = numbers.of(list.verts);
  std::erase(list.verts, kNoGlobal);
  const auto n = static_cast<std::int64_t>(list.verts.size());
  list.first = comm.exclusive_sum(n);
  list.total = comm.sum(n);
}

template <std::size_t N>
bool has_twice(std::array<GlobalId, N> v) noexcept {
  std::sort(v.begin(), v.end());
  return std::adjacent_find(v.begin(), v.end()) != v.end();
}

/// Collective. What each entity becomes: itself, the first with the same vertices, or nothing.
template <std::size_t N>
std::vector<GlobalId> first_of_same(const Comm& comm, const EntitySlice<N>& list) {
  struct Named {
    std::array<GlobalId, N> v;
    GlobalId number;
    auto operator<=>(const Named&) const = default;
  };
  std::vector<Named> named;
  std::vector<Rank> dest;
  for (std::size_t i = 0; i < list.verts.size(); ++i) {
    Named n{list.verts[i], GlobalId{list.first + static_cast<std::int64_t>(i)}};
    std::sort(n.v.begin(), n.v.end());
    named.push_back(n);
    dest.push_back(meeting_rank(hash_of(n.v), comm.size()));
  }
  const Inquiry<Named> inquiry(comm, dest, named);
  auto known = inquiry.asked().items;
  std::sort(known.begin(), known.end());
  std::vector<GlobalId> answers;
  for (const Named& n : inquiry.asked().items)
    answers.push_back(std::lower_bound(known.begin(), known.end(), Named{n.v, GlobalId{0}})->number);
  auto became = inquiry.answer(answers);
  for (std::size_t i = 0; i < became.size(); ++i) {
    if (has_twice(list.verts[i])) became[i] = kNoGlobal;
  }
  return became;
}

template <std::size_t N>
std::vector<GlobalId> all_but_collapsed(const EntitySlice<N>& list) {
  std::vector<GlobalId> became;
  for (std::size_t i = 0; i < list.verts.size(); ++i)
    became.push_back(has_twice(list.verts[i]) ? kNoGlobal : GlobalId{list.first + static_cast<std::int64_t>(i)});
  return became;
}

/// Collective. Entities at the new vertices.
template <std::size_t N>
void renumber_verts(const Renumbering& verts, EntitySlice<N>& list) {
  std::vector<GlobalId> flat;
  for (const auto& v : list.verts) flat.insert(flat.end(), v.begin(), v.end());
  flat = verts.of(flat);
  for (std::size_t i = 0; i < flat.size(); ++i) list.verts[i / N][i % N] = flat[i];
}

/// Removes the entities that are gone.
template <std::size_t N>
std::int64_t close_up(const Renumbering& numbers, EntitySlice<N>& list) {
  const std::int64_t gone = list.total - numbers.total;
  keep_rows(numbers.stays, 1, list.verts);
  keep_rows(numbers.stays, 1, list.ref);
  list.first = numbers.first_number, list.total = numbers.total;
  return gone;
}

}  // namespace

MergeReport merge_vertices(const Comm& comm, double tolerance, MeshSlice& mesh, FieldSlice* values) {
  require_sound(comm, mesh);
  Chains chains(comm, mesh, find_near(comm, mesh, tolerance));
  const Renumbering verts(comm, mesh.first_vert, std::move(chains.lowest));
  MergeReport report;
  report.verts = mesh.total_verts - verts.total;
  if (report.verts == 0) return report;
  renumber_verts(verts, mesh.tets);
  renumber_verts(verts, mesh.triangles);
  renumber_verts(verts, mesh.edges);
  renumber_list(comm, verts, mesh.corners);
  renumber_list(comm, verts, mesh.required_verts);
  const Renumbering tets(comm, mesh.tets.first, all_but_collapsed(mesh.tets));
  const Renumbering triangles(comm, mesh.triangles.first, first_of_same(comm, mesh.triangles));
  const Renumbering edges(comm, mesh.edges.first, first_of_same(comm, mesh.edges));
  renumber_list(comm, triangles, mesh.required_triangles);
  renumber_list(comm, edges, mesh.required_edges);
  renumber_list(comm, edges, mesh.ridges);
  renumber_list(comm, tets, mesh.required_tets);
  report.tets = close_up(tets, mesh.tets);
  report.triangles = close_up(triangles, mesh.triangles);
  report.edges = close_up(edges, mesh.edges);
  keep_rows(verts.stays, 1, mesh.coords);
  keep_rows(verts.stays, 1, mesh.vert_ref);
  mesh.first_vert = verts.first_number, mesh.total_verts = verts.total;
  if (values != nullptr) {
    keep_rows(verts.stays, static_cast<std::size_t>(values->width), values->values);
    values->first = mesh.first_vert, values->total = mesh.total_verts;
  }
  return report;
}

}  // namespace skein
