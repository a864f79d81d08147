// Where bodies touch.
#include "kernel/contact.hpp"

#include <algorithm>

namespace skein {

bool ContactFans::is_at(const TetMesh& m, TetId t, VertId v) noexcept {
  const auto& tv = m.tet2vert[t];
  return tv[0] != kNoVert && std::find(tv.begin(), tv.end(), v) != tv.end();
}

void ContactFans::find(const TetMesh& m) {
  list_of_ = {};
  lists_.clear();
  const auto is_contact = [](VertClass c) { return any(c & kContact); };
  if (std::none_of(m.vert_class.begin(), m.vert_class.end(), is_contact)) return;
  list_of_.assign(m.vert_slots(), -1);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (const VertId v : m.tet2vert[t]) {
      if (m.has(v, kContact)) note(m, v, t);
    }
  }
}

std::span<const TetId> ContactFans::at(VertId v) const noexcept {
  if (idx(v) >= list_of_.size() || list_of_[v] < 0) return {};
  return lists_[static_cast<std::size_t>(list_of_[v])].tets;
}

void ContactFans::note(const TetMesh& m, VertId v, TetId t) {
  if (idx(v) >= list_of_.size()) list_of_.resize(m.vert_slots(), -1);
  if (list_of_[v] < 0) {
    list_of_[v] = static_cast<std::int32_t>(lists_.size());
    lists_.emplace_back();
  }
  List& list = lists_[static_cast<std::size_t>(list_of_[v])];
  list.tets.push_back(t);
  if (list.tets.size() > list.tidy_above) tidy(m, v, list);
}

void ContactFans::tidy(const TetMesh& m, VertId v, List& list) {
  auto& tets = list.tets;
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  std::erase_if(tets, [&](TetId t) { return !is_at(m, t, v); });
  list.tidy_above = 2 * tets.size() + 32;
}

}  // namespace skein
