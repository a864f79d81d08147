// The feature edges of a mesh: ridges, lines, rims and edges with a reference, found by their two vertices.
#pragma once
#include <cstdint>
#include <vector>

#include "base/flag_set.hpp"
#include "base/ids.hpp"

namespace skein {

/// What a feature edge is; a set of flags. An edge without any is kept for its reference.
enum class FeatureClass : std::uint8_t {
  kRidgeEdge = 1,     ///< a ridge of the surface
  kRequiredEdge = 2,  ///< given as required, or an edge of a required triangle or tetrahedron: never split, never gone
  kContactEdge = 4,   ///< bodies touch along it: more than two hull faces have it
  kThinEdge = 8,      ///< at most one tagged face has it: a line inside a region, or the free rim of a sheet
  kImpliedEdge = 16,  ///< an edge of a required triangle or tetrahedron, of no use otherwise: not written
};
using enum FeatureClass;
template <>
inline constexpr bool kIsFlagSet<FeatureClass> = true;

/// One feature edge: all of them are kept, as chains of edges of tetrahedra.
struct FeatureEdge {
  VertId a = kNoVert, b = kNoVert;  ///< a < b
  std::int32_t ref = 0;
  FeatureClass edge_class{};
  [[nodiscard]] bool has(FeatureClass flags) const noexcept { return any(edge_class & flags); }
};

/// Open-addressing hash set of feature edges. Few against the tetrahedra; asked only when both ends carry kRidge or
/// kCorner. Iteration order is the order of insertion, up to erasures (the last takes the erased one's place).
class FeatureEdges {
 public:
  [[nodiscard]] const FeatureEdge* find(VertId a, VertId b) const noexcept;
  void insert(FeatureEdge edge);            ///< replaces an edge that is there; its ends may come in any order
  void erase(VertId a, VertId b) noexcept;  ///< does nothing if it is not there
  /// The edge (a, b) becomes (a, p) and (p, b). @pre it is there
  void split(VertId a, VertId b, VertId p);
  [[nodiscard]] const std::vector<FeatureEdge>& list() const noexcept { return list_; }
  [[nodiscard]] std::size_t size() const noexcept { return list_.size(); }
  void clear() noexcept;

 private:
  [[nodiscard]] std::size_t slot(VertId a, VertId b) const noexcept;
  void rehash(std::size_t capacity);
  std::vector<FeatureEdge> list_;
  std::vector<std::int32_t> table_;  ///< index into list_, or -1
};

}  // namespace skein
