// Parts to slices and back: copies of one thing meet at a rank that follows from its global numbers.
#include "api/parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "api/slices.hpp"
#include "comm/file.hpp"
#include "comm/inquiry.hpp"
#include "dist/gather_slices.hpp"
#include "dist/interface.hpp"
#include "dist/rendezvous.hpp"
#include "dist/sharing.hpp"

namespace skein {
namespace {

// --- checks of one rank's arrays

template <class Lists>
void require_local(const Lists& lists, std::size_t n, const char* what, const char* of) {
  for (const auto& list : lists) {
    for (const std::int32_t i : list) {
      if (i >= 0 && static_cast<std::size_t>(i) < n) continue;
      throw Error(ExitCode::kInvalidMesh,
                  fmt::format("{} names local number {}, but the rank has {} {}, counted from 0", what, i, n, of));
    }
  }
}

void require_numbers(const std::vector<std::int64_t>& numbers, std::size_t n) {
  if (numbers.size() != n) {
    throw Error(ExitCode::kInvalidMesh,
                fmt::format("local2global has {} numbers for {} vertices of a rank", numbers.size(), n));
  }
  std::vector<std::int64_t> sorted(numbers);
  std::sort(sorted.begin(), sorted.end());
  if (!sorted.empty() && sorted.front() < 0) {
    throw Error(ExitCode::kInvalidMesh, fmt::format("local2global has the negative number {}", sorted.front()));
  }
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice == sorted.end()) return;
  throw Error(ExitCode::kInvalidMesh, fmt::format("local2global has number {} twice on one rank", *twice));
}

void check_and_complete(PartitionedMesh& m) {
  using Lists = std::array<std::vector<std::int32_t>, 1>;
  const std::size_t n = m.coords.size();
  require_numbers(m.local2global, n);
  complete_refs(m.vert_refs, n, "vertices");
  complete_refs(m.tet_refs, m.tets.size(), "tetrahedra");
  complete_refs(m.triangle_refs, m.triangles.size(), "triangles");
  complete_refs(m.edge_refs, m.edges.size(), "edges");
  require_local(m.tets, n, "a tetrahedron", "vertices");
  require_local(m.triangles, n, "a triangle", "vertices");
  require_local(m.edges, n, "an edge", "vertices");
  require_local(Lists{m.corners}, n, "the list of corners", "vertices");
  require_local(Lists{m.required_verts}, n, "the list of required vertices", "vertices");
  require_local(Lists{m.ridges}, m.edges.size(), "the list of ridges", "edges");
  require_local(Lists{m.required_edges}, m.edges.size(), "the list of required edges", "edges");
  require_local(Lists{m.required_triangles}, m.triangles.size(), "the list of required triangles", "triangles");
  require_local(Lists{m.required_tets}, m.tets.size(), "the list of required tetrahedra", "tetrahedra");
}

// --- vertices

/// A rank's copy of a vertex on its way to the slice that the vertex belongs to.
struct VertCopy {
  std::int64_t number;
  std::array<double, 3> x;
  std::int32_t ref;
  Rank rank;
};
/// What the slice answers.
struct NewNumber {
  std::int64_t number;
  std::int64_t copies;
};

/// The blocks of numbers that belong to the vertices in `like`, in the same order; `value_of(i)` gives the numbers of
/// item i as it was packed.
std::vector<double> exchange_values(const Comm& comm, const std::vector<Rank>& dest, const std::vector<double>& values,
                                    std::size_t width) {
  std::vector<std::uint32_t> place(dest.size());
  std::iota(place.begin(), place.end(), 0U);
  const Packets<std::uint32_t> order = pack(std::span<const Rank>(dest), std::span<const std::uint32_t>(place));
  Packets<double> send;
  send.rank = order.rank, send.offset = order.offset;
  for (auto& o : send.offset) o *= width;
  send.items.reserve(values.size());
  for (const std::uint32_t i : order.items) {
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(i * width);
    send.items.insert(send.items.end(), from, from + static_cast<std::ptrdiff_t>(width));
  }
  return exchange(comm, std::move(send)).items;
}

/// What came to this slice: the copies by number, those of the lowest rank first.
std::vector<std::uint32_t> sorted_by_number(const std::vector<VertCopy>& copies) {
  std::vector<std::uint32_t> order(copies.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t i, std::uint32_t j) { return copies[i].number < copies[j].number; });
  return order;
}

void require_same_place(const VertCopy& a, const VertCopy& b) {
  if (a.x == b.x) return;
  throw Error(ExitCode::kInvalidMesh,
              fmt::format("vertex {} is at ({:.17g}, {:.17g}, {:.17g}) on rank {}, but at ({:.17g}, {:.17g}, {:.17g}) "
                          "on rank {}; copies of a vertex must have the same bits",
                          a.number, a.x[0], a.x[1], a.x[2], num(a.rank), b.x[0], b.x[1], b.x[2], num(b.rank)));
}

/// Collective. Puts the vertices into slices; gives the new number of each local one, and how many ranks have it.
std::vector<NewNumber> slice_vertices(const Comm& comm, const PartitionedMesh& in, const std::vector<double>& values,
                                      std::size_t width, SlicedParts& out) {
  std::int64_t top = -1;
  for (const std::int64_t g : in.local2global) top = std::max(top, g);
  const std::int64_t range = comm.max(top) + 1;
  std::vector<Rank> dest(in.coords.size());
  std::vector<VertCopy> copies(in.coords.size());
  for (std::size_t i = 0; i < dest.size(); ++i) {
    dest[i] = slice_owner(range, in.local2global[i], comm.size());
    copies[i] = {in.local2global[i], in.coords[i], in.vert_refs[i], comm.rank()};
  }
  const Inquiry<VertCopy> inquiry(comm, dest, copies);
  copies = {};
  const std::vector<double> came = exchange_values(comm, dest, values, width);
  const auto& asked = inquiry.asked().items;
  std::vector<NewNumber> answers(asked.size());
  std::vector<std::uint32_t> first_of;  // the copy that each of the slice's vertices comes from
  agree(comm, [&] {
    const std::vector<std::uint32_t> order = sorted_by_number(asked);
    for (std::size_t i = 0, last = 0; i < order.size(); i = last) {
      while (last < order.size() && asked[order[last]].number == asked[order[i]].number) {
        require_same_place(asked[order[i]], asked[order[last++]]);
      }
      for (std::size_t k = i; k < last; ++k) {
        answers[order[k]] = {std::ssize(first_of), static_cast<std::int64_t>(last - i)};
      }
      first_of.push_back(order[i]);
    }
  });
  const std::int64_t first = comm.exclusive_sum(static_cast<std::int64_t>(first_of.size()));
  for (NewNumber& a : answers) a.number += first;
  for (const std::uint32_t i : first_of) {
    out.mesh.coords.push_back(asked[i].x);
    out.mesh.vert_refs.push_back(asked[i].ref);
    const auto from = came.begin() + static_cast<std::ptrdiff_t>(i * width);
    out.values.insert(out.values.end(), from, from + static_cast<std::ptrdiff_t>(width));
  }
  return inquiry.answer(answers);
}

// --- triangles and edges, which several ranks may have

enum Mark : std::uint8_t { kMarkRidge = 1, kMarkRequired = 2 };

/// A rank's copy of a triangle or an edge.
template <std::size_t N>
struct EntityCopy {
  std::array<std::int64_t, N> verts;  ///< ascending
  Rank rank;
  std::uint8_t marks;
};
struct Keep {
  bool keep;
  std::uint8_t marks;  ///< of all copies
};

/// What the rank where copies meet answers: the lowest rank's stay. One given twice on one rank stays twice, and is
/// refused later.
template <std::size_t N>
std::vector<Keep> judge_copies(const std::vector<EntityCopy<N>>& met) {
  std::vector<std::uint32_t> order(met.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t i, std::uint32_t j) { return met[i].verts < met[j].verts; });
  std::vector<Keep> out(met.size());
  for (std::size_t i = 0, last = 0; i < order.size(); i = last) {
    const EntityCopy<N>& first = met[order[i]];
    std::uint8_t marks = 0;
    for (; last < order.size() && met[order[last]].verts == first.verts; ++last) {
      marks = static_cast<std::uint8_t>(marks | met[order[last]].marks);
    }
    for (std::size_t k = i; k < last; ++k) out[order[k]] = {met[order[k]].rank == first.rank, marks};
  }
  return out;
}

/// Collective. For each entity whether this rank gives it, and its marks.
template <std::size_t N>
std::vector<Keep> keep_once(const Comm& comm, const std::vector<std::array<std::int32_t, N>>& entities,
                            const std::vector<NewNumber>& number, const std::vector<std::uint8_t>& marks) {
  std::vector<Keep> out(entities.size());
  std::vector<std::size_t> doubtful;
  std::vector<Rank> dest;
  std::vector<EntityCopy<N>> copies;
  for (std::size_t i = 0; i < entities.size(); ++i) {
    out[i] = {true, marks[i]};
    EntityCopy<N> copy{{}, comm.rank(), marks[i]};
    bool shared = true;
    for (std::size_t k = 0; k < N; ++k) {
      const NewNumber& n = number[static_cast<std::size_t>(entities[i][k])];
      copy.verts[k] = n.number;
      shared = shared && n.copies > 1;
    }
    if (!shared) continue;
    std::sort(copy.verts.begin(), copy.verts.end());
    doubtful.push_back(i);
    dest.push_back(meeting_rank(GlobalId{copy.verts[0]}, comm.size()));
    copies.push_back(copy);
  }
  const Inquiry<EntityCopy<N>> inquiry(comm, dest, copies);
  const std::vector<Keep> answer = inquiry.answer(judge_copies(inquiry.asked().items));
  for (std::size_t i = 0; i < doubtful.size(); ++i) out[doubtful[i]] = answer[i];
  return out;
}

std::vector<std::uint8_t> marks_of(std::size_t n, const std::vector<std::int32_t>& ridges,
                                   const std::vector<std::int32_t>& required) {
  std::vector<std::uint8_t> marks(n, 0);
  for (const std::int32_t i : ridges) marks[static_cast<std::size_t>(i)] |= kMarkRidge;
  for (const std::int32_t i : required) marks[static_cast<std::size_t>(i)] |= kMarkRequired;
  return marks;
}

template <std::size_t N>
std::array<std::int64_t, N> numbered(const std::array<std::int32_t, N>& local, const std::vector<NewNumber>& number) {
  std::array<std::int64_t, N> out;
  for (std::size_t k = 0; k < N; ++k) out[k] = number[static_cast<std::size_t>(local[k])].number;
  return out;
}

/// Collective. Triangles or edges of the parts into slices.
template <std::size_t N>
struct EntityLists {
  std::vector<std::array<std::int64_t, N>>& verts;
  std::vector<std::int32_t>& refs;
  std::vector<std::int64_t>*ridges, &required;
};
template <std::size_t N>
void slice_entities(const Comm& comm, const std::vector<std::array<std::int32_t, N>>& entities,
                    const std::vector<std::int32_t>& refs, const std::vector<NewNumber>& number,
                    const std::vector<std::uint8_t>& marks, EntityLists<N> out) {
  const std::vector<Keep> keep = keep_once(comm, entities, number, marks);
  const std::int64_t first = comm.exclusive_sum(
      static_cast<std::int64_t>(std::count_if(keep.begin(), keep.end(), [](Keep k) { return k.keep; })));
  for (std::size_t i = 0; i < entities.size(); ++i) {
    if (!keep[i].keep) continue;
    const std::int64_t me = first + std::ssize(out.verts);
    if (out.ridges != nullptr && (keep[i].marks & kMarkRidge) != 0) out.ridges->push_back(me);
    if ((keep[i].marks & kMarkRequired) != 0) out.required.push_back(me);
    out.verts.push_back(numbered(entities[i], number));
    out.refs.push_back(refs[i]);
  }
}

// --- back

std::vector<std::int32_t> flagged(const TetMesh& mesh, VertClass flag) {
  std::vector<std::int32_t> out;
  for (const VertId v : IdRange<VertId>(mesh.vert_slots())) {
    if (mesh.has(v, flag)) out.push_back(num(v));
  }
  return out;
}

}  // namespace

SlicedParts to_slices(const Comm& comm, PartitionedMesh in, std::vector<double> values, std::size_t width) {
  agree(comm, [&] { check_and_complete(in); });
  SlicedParts out;
  SlicedMesh& m = out.mesh;
  const std::vector<NewNumber> number = slice_vertices(comm, in, values, width, out);
  values = {}, in.coords = {}, in.vert_refs = {}, in.local2global = {};
  m.tets.reserve(in.tets.size());
  for (const auto& t : in.tets) m.tets.push_back(numbered(t, number));
  m.tet_refs = std::move(in.tet_refs);
  const std::int64_t first_tet = comm.exclusive_sum(std::ssize(m.tets));
  for (const std::int32_t t : in.required_tets) m.required_tets.push_back(first_tet + t);
  in.tets = {};
  slice_entities<3>(comm, in.triangles, in.triangle_refs, number,
                    marks_of(in.triangles.size(), {}, in.required_triangles),
                    {m.triangles, m.triangle_refs, nullptr, m.required_triangles});
  slice_entities<2>(comm, in.edges, in.edge_refs, number, marks_of(in.edges.size(), in.ridges, in.required_edges),
                    {m.edges, m.edge_refs, &m.ridges, m.required_edges});
  for (const std::int32_t v : in.corners) m.corners.push_back(number[static_cast<std::size_t>(v)].number);
  for (const std::int32_t v : in.required_verts) m.required_verts.push_back(number[static_cast<std::size_t>(v)].number);
  return out;
}

PartitionedMesh to_partitioned_mesh(const Comm& comm, DistMesh&& dist) {
  TetMesh& m = dist.mesh;
  PartitionedMesh out;
  for (const FaceId f : faces_to_write(comm, dist)) {
    const auto v = m.verts(f);
    const FaceTag tag = m.tag(f);
    if ((tag & kRequiredFace) != 0) out.required_triangles.push_back(static_cast<std::int32_t>(out.triangles.size()));
    out.triangles.push_back({num(v[0]), num(v[1]), num(v[2])});
    out.triangle_refs.push_back(m.patch_ref[static_cast<std::size_t>(tag_patch(tag))]);
  }
  for (const FeatureEdge& e : edges_to_write(comm, dist)) {
    if (e.has(kRidgeEdge)) out.ridges.push_back(static_cast<std::int32_t>(out.edges.size()));
    if (e.has(kRequiredEdge)) out.required_edges.push_back(static_cast<std::int32_t>(out.edges.size()));
    out.edges.push_back({num(e.a), num(e.b)});
    out.edge_refs.push_back(e.ref);
  }
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (m.has(t, kRequiredTet)) out.required_tets.push_back(num(t));
  }
  out.corners = flagged(m, kCorner);
  out.required_verts = flagged(m, kRequired);
  out.local2global = compact_numbers(comm, dist);
  out.vert_refs = std::move(m.vert_ref.raw());
  out.tet_refs = std::move(m.tet_ref.raw());
  out.coords = converted<std::array<double, 3>>(std::move(m.coords.raw()));
  m.tet2face = {}, m.face_tag = {};
  out.tets = converted<std::array<std::int32_t, 4>>(std::move(m.tet2vert.raw()));
  return out;
}

}  // namespace skein
