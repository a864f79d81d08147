// The feature edges of a mesh: ridges and edges with a reference, found by their two vertices.
#pragma once
#include <cstdint>
#include <vector>

#include "base/ids.hpp"

namespace skein {

/// One feature edge. `ridge` edges keep their geometry; an edge with a reference only is kept, too.
struct FeatureEdge {
  VertId a = kNoVert, b = kNoVert;  ///< a < b
  std::int32_t ref = 0;
  bool ridge = false;
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
