// Open-addressing hash set of feature edges: linear probing, erasure by shifting back.
#include "mesh/feature_edges.hpp"

#include <algorithm>

#include "base/hash.hpp"

namespace skein {
namespace {
std::uint64_t hash_of(VertId a, VertId b) noexcept {
  return table_hash(static_cast<std::uint64_t>(num(a)) << 32 | static_cast<std::uint32_t>(num(b)));
}
}  // namespace

std::size_t FeatureEdges::slot(VertId a, VertId b) const noexcept {
  const std::size_t mask = table_.size() - 1;
  std::size_t s = hash_of(a, b) & mask;
  while (table_[s] >= 0) {
    const auto& e = list_[table_[s]];
    if (e.a == a && e.b == b) break;
    s = (s + 1) & mask;
  }
  return s;
}

const FeatureEdge* FeatureEdges::find(VertId a, VertId b) const noexcept {
  if (list_.empty()) return nullptr;
  if (b < a) std::swap(a, b);
  const auto at = table_[slot(a, b)];
  return at < 0 ? nullptr : &list_[at];
}

void FeatureEdges::rehash(std::size_t capacity) {
  table_.assign(capacity, -1);
  for (std::size_t i = 0; i < list_.size(); ++i) table_[slot(list_[i].a, list_[i].b)] = static_cast<std::int32_t>(i);
}

void FeatureEdges::insert(FeatureEdge edge) {
  if (edge.b < edge.a) std::swap(edge.a, edge.b);
  if (2 * (list_.size() + 1) > table_.size()) rehash(std::max<std::size_t>(16, 2 * table_.size()));
  const std::size_t s = slot(edge.a, edge.b);
  if (table_[s] >= 0) {
    list_[table_[s]] = edge;
    return;
  }
  table_[s] = static_cast<std::int32_t>(list_.size());
  list_.push_back(edge);
}

void FeatureEdges::erase(VertId a, VertId b) noexcept {
  if (list_.empty()) return;
  if (b < a) std::swap(a, b);
  const std::size_t mask = table_.size() - 1;
  std::size_t gap = slot(a, b);
  if (table_[gap] < 0) return;
  const auto gone = static_cast<std::size_t>(table_[gap]);
  table_[gap] = -1;
  for (std::size_t s = (gap + 1) & mask; table_[s] >= 0; s = (s + 1) & mask) {
    const auto& e = list_[table_[s]];
    const std::size_t home = hash_of(e.a, e.b) & mask;
    if (((s - home) & mask) >= ((s - gap) & mask)) {
      table_[gap] = table_[s];
      table_[s] = -1;
      gap = s;
    }
  }
  if (gone + 1 < list_.size()) {
    const auto last = list_.back();
    table_[slot(last.a, last.b)] = static_cast<std::int32_t>(gone);
    list_[gone] = last;
  }
  list_.pop_back();
}

void FeatureEdges::split(VertId a, VertId b, VertId p) {
  const FeatureEdge e = *find(a, b);
  erase(a, b);
  insert({a, p, e.ref, e.edge_class});
  insert({p, b, e.ref, e.edge_class});
}

void FeatureEdges::clear() noexcept {
  list_.clear();
  table_.clear();
}

}  // namespace skein
