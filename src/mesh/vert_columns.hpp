// Vertex columns: the list of all that a mesh keeps for its vertices, and what is done to every column alike.
//
// A new attribute is a member of VertColumns and an entry of kVertColumns (a static assertion fails without it). It
// then travels with its vertices wherever they go: renumbering, growth, free slots, blocks, bands, migration.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <vector>

#include "base/flag_set.hpp"
#include "base/ids.hpp"
#include "base/tensor.hpp"
#include "base/vec3.hpp"
#include "mesh/surface_place.hpp"

namespace skein {

/// What a vertex is; a set of flags.
enum class VertClass : std::uint8_t {
  kSurface = 1,   ///< lies on a tagged face (domain boundary or internal interface)
  kRidge = 2,     ///< lies on a feature edge
  kCorner = 4,    ///< never moves, never goes (end or junction of feature edges, or given as corner)
  kRequired = 8,  ///< given as required: never moves, never goes
  kContact = 16,  ///< bodies touch here: its tetrahedra need not hang together over faces
  kThin = 32,     ///< lies on a feature edge that at most one tagged face has (kThinEdge)
  kFixed = 64,    ///< of a required edge, triangle or tetrahedron: never moves, never goes
};
/// What is to be done at a vertex; a set of flags.
enum class VertState : std::uint8_t {
  kFrozen = 1,        ///< on the interface to another part: not to be touched in this round
  kActive = 2,        ///< still to be looked at
  kBesideFrozen = 4,  ///< of a tetrahedron that could be better and has a vertex that had to stay in the last round
  kRetry = 8,         ///< what is round it is to be looked at first: a frozen vertex was in the way of the last round
  kWasFrozen = 16,    ///< was frozen before the mesh was cut into blocks
};
using enum VertClass;
using enum VertState;
template <>
inline constexpr bool kIsFlagSet<VertClass> = true;
/// A vertex with one of these stays where it is.
inline constexpr VertClass kStays{8 | 4 | 64};
template <>
inline constexpr bool kIsFlagSet<VertState> = true;

/// Where a vertex was when its metric came from outside, or where it was made, and the metric there. What is
/// interpolated from there when it moves has the error of one interpolation, not of as many as it has moved.
struct Anchor {
  Vec3 x;
  SymTensor log_m;
};

/// A column of `width` numbers per vertex, vertex after vertex: fields of a solution that are carried along.
struct VertFields {
  int width = 0;
  std::vector<double> values;
  [[nodiscard]] double* at(VertId v) noexcept { return values.data() + idx(v) * static_cast<std::size_t>(width); }
  [[nodiscard]] const double* at(VertId v) const noexcept {
    return values.data() + idx(v) * static_cast<std::size_t>(width);
  }
  [[nodiscard]] bool empty() const noexcept { return values.empty(); }
  /// Vertices.
  [[nodiscard]] std::size_t size() const noexcept {
    return width == 0 ? 0 : values.size() / static_cast<std::size_t>(width);
  }
  std::vector<double>& raw() noexcept { return values; }
  [[nodiscard]] const std::vector<double>& raw() const noexcept { return values; }
};

/// The attributes of vertices. A column has one entry per vertex slot, or it is empty: then the mesh does without it.
/// The first four are always there.
struct VertColumns {
  IdVector<VertId, Vec3> coords;            ///< length unit of the input
  IdVector<VertId, std::int32_t> vert_ref;  ///< reference of the file
  IdVector<VertId, VertClass> vert_class;
  IdVector<VertId, VertState> vert_state;
  IdVector<VertId, SymTensor> log_metric;  ///< logarithm of the wanted metric, as it is interpolated
  IdVector<VertId, VertMetric> metric;     ///< the metric as it measures; made from log_metric, see measure_metric()
  IdVector<VertId, Anchor> anchor;
  IdVector<VertId, SurfacePlace> surface_place;  ///< of vertices on the boundary; empty without a reference surface
  VertFields fields;
};
inline constexpr std::tuple kVertColumns{
    &VertColumns::coords,     &VertColumns::vert_ref,      &VertColumns::vert_class,
    &VertColumns::vert_state, &VertColumns::log_metric,    &VertColumns::metric,
    &VertColumns::anchor,     &VertColumns::surface_place, &VertColumns::fields,
};
inline constexpr std::size_t kVertColumnCount = std::tuple_size_v<decltype(kVertColumns)>;

/// Calls f(column) for every column, also empty ones.
template <class F>
void for_each_vert_column(VertColumns& m, F&& f) {
  std::apply([&](auto... c) { (f(m.*c), ...); }, kVertColumns);
}
template <class F>
void for_each_vert_column(const VertColumns& m, F&& f) {
  std::apply([&](auto... c) { (f(m.*c), ...); }, kVertColumns);
}
/// The same for the columns of two meshes, side by side: f(column of a, column of b).
template <class F>
void for_each_vert_column(VertColumns& a, const VertColumns& b, F&& f) {
  std::apply([&](auto... c) { (f(a.*c, b.*c), ...); }, kVertColumns);
}

static_assert(std::apply([](auto... c) { return (sizeof(std::declval<VertColumns&>().*c) + ...); }, kVertColumns) ==
                  sizeof(VertColumns),
              "every member of VertColumns belongs into kVertColumns");

/// Numbers per vertex.
template <class T>
constexpr std::size_t width_of(const IdVector<VertId, T>&) noexcept {
  return 1;
}
inline std::size_t width_of(const VertFields& c) noexcept { return static_cast<std::size_t>(c.width); }
template <class Column>
using EntryOf = typename std::remove_cvref_t<decltype(std::declval<Column&>().raw())>::value_type;

/// What a new vertex has in a column that nobody has filled.
template <class T>
inline constexpr T kNewEntry{};
template <>
inline constexpr GlobalId kNewEntry<GlobalId> = kNoGlobal;
template <>
inline constexpr SurfacePlace kNewEntry<SurfacePlace> = SurfacePlace::kUnknown;

template <class T>
void take_width(IdVector<VertId, T>&, const IdVector<VertId, T>&) noexcept {}
inline void take_width(VertFields& to, const VertFields& from) noexcept { to.width = from.width; }

/// The column to n vertices; new ones get kNewEntry.
template <class Column>
void resize_column(Column& c, std::size_t n) {
  c.raw().resize(n * width_of(c), kNewEntry<EntryOf<Column>>);
}
/// Vertex `to` of one column gets what vertex `from` of the other has. @pre neither is empty
template <class Column>
void copy_entry(Column& c, VertId to, const Column& other, VertId from) noexcept {
  if constexpr (std::is_same_v<Column, VertFields>) {
    std::copy_n(other.at(from), c.width, c.at(to));
  } else {
    c[to] = other[from];
  }
}
template <class Column>
void clear_entry(Column& c, VertId v) noexcept {
  std::fill_n(c.raw().begin() + static_cast<std::ptrdiff_t>(idx(v) * width_of(c)), width_of(c),
              kNewEntry<EntryOf<Column>>);
}
/// `to` becomes the entries of the vertices `verts`, in this order, with room for `room` vertices.
template <class Column, class Verts>
void gather_column(Column& to, const Column& from, const Verts& verts, std::size_t room = 0) {
  if (from.empty()) return;
  take_width(to, from);
  to.raw().clear();
  to.raw().reserve(std::max(room, verts.size()) * width_of(from));
  for (const VertId v : verts) {
    if constexpr (std::is_same_v<Column, VertFields>) {
      to.values.insert(to.values.end(), from.at(v), from.at(v) + from.width);
    } else {
      to.push_back(from[v]);
    }
  }
}
/// Follows a renumbering that keeps the order, to n vertices; those whose new number is none are dropped.
template <class Column>
void squeeze_column(Column& c, const IdVector<VertId, VertId>& old2new, std::size_t n) {
  if (c.empty()) return;
  for (const VertId v : IdRange<VertId>(old2new.size())) {
    if (old2new[v] != kNoVert) copy_entry(c, old2new[v], c, v);
  }
  resize_column(c, n);
}

/// Every column that is there gets one more vertex, with nothing in it. @pre there are vertices
template <class Mesh>
void append_entries(Mesh& m) {
  for_each_vert_column(m, [](auto& c) {
    if (!c.empty()) c.raw().resize(c.raw().size() + width_of(c), kNewEntry<EntryOf<decltype(c)>>);
  });
}
/// Vertex v has nothing in any column.
template <class Mesh>
void clear_entries(Mesh& m, VertId v) {
  for_each_vert_column(m, [&](auto& c) {
    if (!c.empty()) clear_entry(c, v);
  });
}
/// Vertex `to` gets in every column what `from` has there.
template <class Mesh>
void move_entries(Mesh& m, VertId from, VertId to) {
  for_each_vert_column(m, [&](auto& c) {
    if (!c.empty()) copy_entry(c, to, c, from);
  });
}
/// Vertex `to` gets what vertex `from` of another mesh has, in the columns that both have.
inline void copy_entries(VertColumns& m, VertId to, const VertColumns& other, VertId from) {
  for_each_vert_column(m, other, [&](auto& c, const auto& o) {
    if (!c.empty() && !o.empty()) copy_entry(c, to, o, from);
  });
}

}  // namespace skein
