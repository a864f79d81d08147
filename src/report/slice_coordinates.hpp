// Coordinates at the vertices of entities that a rank has, from the slices of all ranks.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "comm/exchange.hpp"
#include "dist/blocks.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein {

/// Coordinates of any vertices that this rank asks for: its own slice, and what it fetched.
class SliceCoordinates {
 public:
  /// Collective. Marks the vertices asked for in `marks` of the rank that has them.
  template <std::size_t N>
  SliceCoordinates(const Comm& comm, const MeshSlice& mesh, const std::vector<std::array<GlobalId, N>>& entities,
                   std::vector<char>* marks)
      : mesh_(&mesh) {
    for (const auto& verts : entities) {
      for (const GlobalId g : verts) {
        if (!is_own(g)) {
          ids_.push_back(g);
        } else if (marks != nullptr) {
          (*marks)[own(g)] = 1;
        }
      }
    }
    std::sort(ids_.begin(), ids_.end());
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    std::vector<Rank> dest;
    const Blocks blocks(comm, mesh.first_vert);
    for (const GlobalId g : ids_) dest.push_back(blocks.owner(num(g)));
    const auto sent = pack(std::span<const Rank>(dest), std::span<const GlobalId>(ids_));
    const auto asked = exchange(comm, sent);
    std::vector<Vec3> answers;
    for (const GlobalId g : asked.items) {
      answers.push_back(mesh.coords[own(g)]);
      if (marks != nullptr) (*marks)[own(g)] = 1;
    }
    coords_ = reply(comm, sent, asked, std::span<const Vec3>(answers));  // owners ascend with the ids: same order
  }
  [[nodiscard]] Vec3 operator[](GlobalId g) const noexcept {
    if (is_own(g)) return mesh_->coords[own(g)];
    return coords_[std::lower_bound(ids_.begin(), ids_.end(), g) - ids_.begin()];
  }

 private:
  [[nodiscard]] std::size_t own(GlobalId g) const noexcept {
    return static_cast<std::size_t>(num(g) - mesh_->first_vert);
  }
  [[nodiscard]] bool is_own(GlobalId g) const noexcept {
    return num(g) >= mesh_->first_vert && own(g) < mesh_->coords.size();
  }
  const MeshSlice* mesh_;
  std::vector<GlobalId> ids_;
  std::vector<Vec3> coords_;
};

}  // namespace skein
