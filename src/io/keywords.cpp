// The table of keywords, and the error lines that the binary and the text reader share.
#include "io/keywords.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.hpp"

namespace skein::io {
namespace {

constexpr std::array<KeywordInfo, 24> kTable{{
    {3, "Dimension", "dimension", false},
    {4, "Vertices", "vertex", false},
    {5, "Edges", "edge", false},
    {6, "Triangles", "triangle", false},
    {7, "Quadrilaterals", "quadrilateral", true},
    {8, "Tetrahedra", "tetrahedron", false},
    {9, "Prisms", "prism", true},
    {10, "Hexahedra", "hexahedron", true},
    {12, "RequiredTetrahedra", "required tetrahedron", false},
    {13, "Corners", "corner", false},
    {14, "Ridges", "ridge", false},
    {15, "RequiredVertices", "required vertex", false},
    {16, "RequiredEdges", "required edge", false},
    {17, "RequiredTriangles", "required triangle", false},
    {24, "TrianglesP2", "quadratic triangle", true},
    {25, "EdgesP2", "quadratic edge", true},
    {27, "QuadrilateralsQ2", "quadratic quadrilateral", true},
    {30, "TetrahedraP2", "quadratic tetrahedron", true},
    {33, "HexahedraQ2", "quadratic hexahedron", true},
    {46, "Polyhedra", "polyhedron", true},
    {47, "Polygons", "polygon", true},
    {49, "Pyramids", "pyramid", true},
    {54, "End", "end", false},
    {62, "SolAtVertices", "value at a vertex", false},
}};

/// Sections that files often have and Skein does not keep.
constexpr std::array<std::pair<std::int32_t, std::string_view>, 9> kPassedOver{{
    {19, "TangentAtEdgeVertices"},
    {20, "NormalAtVertices"},
    {21, "NormalAtTriangleVertices"},
    {40, "VerticesOnGeometricVertices"},
    {41, "VerticesOnGeometricEdges"},
    {42, "VerticesOnGeometricTriangles"},
    {59, "Tangents"},
    {60, "Normals"},
    {126, "ByteFlow"},
}};

}  // namespace

std::string unknown_name(std::int32_t code) {
  for (const auto& [known, name] : kPassedOver) {
    if (known == code) return std::string(name);
  }
  return fmt::format("keyword {}", code);
}

const KeywordInfo* find_keyword(std::int32_t code) noexcept {
  const auto it = std::ranges::find(kTable, code, &KeywordInfo::code);
  return it == kTable.end() ? nullptr : &*it;
}

const KeywordInfo* find_keyword(std::string_view name) noexcept {
  const auto it = std::ranges::find(kTable, name, &KeywordInfo::name);
  return it == kTable.end() ? nullptr : &*it;
}

const KeywordInfo& info(Keyword k) noexcept { return *find_keyword(static_cast<std::int32_t>(k)); }

void refuse_elements(const std::string& where, const KeywordInfo& k, std::int64_t count) {
  if (!k.refused || count <= 0) return;
  throw Error(ExitCode::kInput,
              fmt::format("{}: {} {} in the file; Skein takes linear edges, triangles and tetrahedra only: split the "
                          "others into these, or take them out",
                          where, count, k.name));
}

void require_dimension_3(const std::string& where, std::int64_t dimension) {
  if (dimension == 3) return;
  throw Error(ExitCode::kInput,
              fmt::format("{}: Dimension is {}, but Skein needs a file of dimension 3", where, dimension));
}

void require_field_count(const std::string& where, std::int64_t count) {
  if (count >= 1 && count <= kMaxFields) return;
  throw Error(ExitCode::kInput, fmt::format("{}: SolAtVertices announces {} fields; 1 to {} are possible: is the file "
                                            "damaged?",
                                            where, count, kMaxFields));
}

FieldKind field_kind(const std::string& where, std::int64_t field, std::int64_t kind) {
  if (kind >= 1 && kind <= 3) return static_cast<FieldKind>(kind);
  throw Error(ExitCode::kInput, fmt::format("{}: field {} of SolAtVertices is of kind {}; known are 1 (scalar), 2 "
                                            "(vector) and 3 (symmetric tensor)",
                                            where, field + 1, kind));
}

void throw_bad_number(const std::string& where, const RecordSpec& spec, std::int64_t record, int field,
                      std::int64_t value) {
  const std::string_view one = info(spec.key).one;
  if (field >= spec.indices) {
    throw Error(ExitCode::kInput, fmt::format("{}: the reference {} of {} {} does not fit into 32 bits: renumber the "
                                              "references",
                                              where, value, one, record + 1));
  }
  const std::string_view named = info(spec.named).one;
  const std::string_view list = info(spec.named).name;
  const std::string have = spec.limit > 0 ? fmt::format("but the file has numbers 1 to {} in {}", spec.limit, list)
                                          : fmt::format("but the file has no {}", list);
  throw Error(ExitCode::kInput, fmt::format("{}: {} {} names {} {}, {}: write the file again", where, one, record + 1,
                                            named, value, have));
}

void throw_not_finite_coordinate(const std::string& where, std::int64_t vertex) {
  throw Error(ExitCode::kInput, fmt::format("{}: vertex {} has a coordinate that is not a finite number (NaN or "
                                            "infinite): correct the file",
                                            where, vertex + 1));
}

void throw_not_finite_value(const std::string& where, std::int64_t vertex, const FieldSlice& fields, int component) {
  std::size_t field = 0;
  int left = component;
  while (left >= components(fields.kinds[field])) left -= components(fields.kinds[field++]);
  throw Error(ExitCode::kInput, fmt::format("{}: field {} has a value at vertex {} that is not a finite number (NaN or "
                                            "infinite): correct the solution",
                                            where, field + 1, vertex + 1));
}

}  // namespace skein::io
