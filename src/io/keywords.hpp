// The keywords that GMF binary and Medit text share, and the sections of a mesh file as one list of records.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "mesh/mesh_slice.hpp"

namespace skein::io {

/// Codes as in the binary files.
enum class Keyword : std::int32_t {
  kDimension = 3,
  kVertices = 4,
  kEdges = 5,
  kTriangles = 6,
  kTetrahedra = 8,
  kRequiredTetrahedra = 12,  ///< as Mmg writes it
  kCorners = 13,
  kRidges = 14,
  kRequiredVertices = 15,
  kRequiredEdges = 16,
  kRequiredTriangles = 17,
  kEnd = 54,
  kSolAtVertices = 62
};

struct KeywordInfo {
  std::int32_t code;
  std::string_view name;  ///< as in text files
  std::string_view one;   ///< one entity, for messages
  bool refused;           ///< elements that Skein cannot keep: a file with such is refused
};
/// nullptr for a keyword that Skein ignores.
const KeywordInfo* find_keyword(std::int32_t code) noexcept;
const KeywordInfo* find_keyword(std::string_view name) noexcept;
/// @pre one of Keyword.
const KeywordInfo& info(Keyword k) noexcept;
/// What a keyword that Skein does not know is called: its name, where it is a usual one.
std::string unknown_name(std::int32_t code);
/// Throws Error(kInput) when `k` is refused and count > 0. `where` is the head of the message.
void refuse_elements(const std::string& where, const KeywordInfo& k, std::int64_t count);
/// Throws Error(kInput) unless dimension is 3.
void require_dimension_3(const std::string& where, std::int64_t dimension);

/// The most fields side by side in one solution file.
inline constexpr std::int64_t kMaxFields = 64;
/// Throws Error(kInput) when the number of fields, or the kind number of one, is not one we know.
void require_field_count(const std::string& where, std::int64_t count);
FieldKind field_kind(const std::string& where, std::int64_t field, std::int64_t kind);

/// The layout of a record: `indices` entity numbers from 1 to `limit`, then a reference if width > indices.
struct RecordSpec {
  Keyword key;
  int width = 0;
  int indices = 0;
  std::int64_t limit = 0;  ///< number of entities that the indices can name
  Keyword named{};         ///< the entities that the indices name: kVertices, kEdges, kTriangles or kTetrahedra
};
/// Throws the Error for number `value` at `field` of record `record` (from 0).
[[noreturn]] void throw_bad_number(const std::string& where, const RecordSpec& spec, std::int64_t record, int field,
                                   std::int64_t value);
[[noreturn]] void throw_not_finite_coordinate(const std::string& where, std::int64_t vertex);
[[noreturn]] void throw_not_finite_value(const std::string& where, std::int64_t vertex, const FieldSlice& fields,
                                         int component);
constexpr bool fits_ref(std::int64_t v) noexcept { return v >= INT32_MIN && v <= INT32_MAX; }
constexpr bool good_number(const RecordSpec& s, int field, std::int64_t v) noexcept {
  return field < s.indices ? v >= 1 && v <= s.limit : fits_ref(v);
}

// A section's slice as records of `record_width` whole numbers, numbered from 1 as in the file.
template <std::size_t N>
constexpr int record_width(const EntitySlice<N>&) noexcept {
  return static_cast<int>(N) + 1;
}
constexpr int record_width(const VertexListSlice&) noexcept { return 1; }
template <std::size_t N>
constexpr int record_indices(const EntitySlice<N>&) noexcept {
  return static_cast<int>(N);
}
constexpr int record_indices(const VertexListSlice&) noexcept { return 1; }
template <std::size_t N>
void resize_records(EntitySlice<N>& s, std::size_t n) {
  s.verts.resize(n);
  s.ref.resize(n);
}
inline void resize_records(VertexListSlice& s, std::size_t n) { s.verts.resize(n); }
template <std::size_t N>
void store_record(EntitySlice<N>& s, std::size_t i, const std::int64_t* number) noexcept {
  for (std::size_t k = 0; k < N; ++k) s.verts[i][k] = GlobalId{number[k] - 1};
  s.ref[i] = static_cast<std::int32_t>(number[N]);
}
inline void store_record(VertexListSlice& s, std::size_t i, const std::int64_t* number) noexcept {
  s.verts[i] = GlobalId{number[0] - 1};
}
template <std::size_t N>
void load_record(const EntitySlice<N>& s, std::size_t i, std::int64_t* number) noexcept {
  for (std::size_t k = 0; k < N; ++k) number[k] = num(s.verts[i][k]) + 1;
  number[N] = s.ref[i];
}
inline void load_record(const VertexListSlice& s, std::size_t i, std::int64_t* number) noexcept {
  number[0] = num(s.verts[i]) + 1;
}

/// Calls f(spec, slice) for every section but the vertices, in the order in which they are written. The limits of the
/// specs follow from the totals of `mesh`.
template <class Mesh, class F>
void for_each_section(Mesh& mesh, F&& f) {
  const auto call = [&](Keyword key, auto& slice, Keyword named, std::int64_t limit) {
    f(RecordSpec{key, record_width(slice), record_indices(slice), limit, named}, slice);
  };
  call(Keyword::kCorners, mesh.corners, Keyword::kVertices, mesh.total_verts);
  call(Keyword::kRequiredVertices, mesh.required_verts, Keyword::kVertices, mesh.total_verts);
  call(Keyword::kEdges, mesh.edges, Keyword::kVertices, mesh.total_verts);
  call(Keyword::kRidges, mesh.ridges, Keyword::kEdges, mesh.edges.total);
  call(Keyword::kRequiredEdges, mesh.required_edges, Keyword::kEdges, mesh.edges.total);
  call(Keyword::kTriangles, mesh.triangles, Keyword::kVertices, mesh.total_verts);
  call(Keyword::kRequiredTriangles, mesh.required_triangles, Keyword::kTriangles, mesh.triangles.total);
  call(Keyword::kTetrahedra, mesh.tets, Keyword::kVertices, mesh.total_verts);
  call(Keyword::kRequiredTetrahedra, mesh.required_tets, Keyword::kTetrahedra, mesh.tets.total);
}

}  // namespace skein::io
