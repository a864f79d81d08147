// Templates of interface_faces.hpp.
#pragma once
#include <algorithm>
#include <cstdint>

#include "dist/interface_faces.hpp"
#include "dist/rendezvous.hpp"

namespace skein {

template <Sendable T>
std::vector<T> swap_over_interface(const Comm& comm, const std::vector<InterfaceFace>& faces,
                                   const std::vector<T>& value) {
  struct Item {
    FaceId face;
    T value;
  };
  std::vector<Rank> dest(faces.size());
  std::vector<Item> items(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    dest[i] = faces[i].rank;
    items[i] = {faces[i].theirs, value[i]};
  }
  const auto got = exchange_items(comm, dest, items);
  std::vector<T> out(faces.size());
  for (const Item& item : got.items) {
    const auto it = std::lower_bound(faces.begin(), faces.end(), item.face,
                                     [](const InterfaceFace& f, FaceId id) { return f.mine < id; });
    if (it != faces.end() && it->mine == item.face) out[it - faces.begin()] = item.value;
  }
  return out;
}

}  // namespace skein
