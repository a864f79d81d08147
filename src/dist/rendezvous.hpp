// Rendezvous: ranks that have copies of the same vertex, edge or face send a message to the same third rank, which
// follows from the global ids alone. There they find each other.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/hash.hpp"
#include "base/ids.hpp"
#include "base/radix_sort.hpp"
#include "comm/inquiry.hpp"
#include "mesh/tet_mesh.hpp"

namespace skein {

constexpr std::uint64_t mix(GlobalId g) noexcept { return mix(static_cast<std::uint64_t>(num(g))); }
/// The rank to which all that know the item with this hash send their message.
constexpr Rank meeting_rank(std::uint64_t hash, int ranks) noexcept {
  return to_id<Rank>((hash >> 16) % static_cast<std::uint64_t>(ranks));
}
constexpr Rank meeting_rank(GlobalId g, int ranks) noexcept { return meeting_rank(mix(g), ranks); }

/// Of some ids in this order.
template <std::size_t N>
constexpr std::uint64_t hash_of(const std::array<GlobalId, N>& gid) noexcept {
  std::uint64_t h = mix(gid[0]);
  for (std::size_t i = 1; i < N; ++i) h = mix(h ^ static_cast<std::uint64_t>(num(gid[i])));
  return h;
}

/// A face by its global ids, ascending. `odd` tells the orientation: the outward order of the face is an odd
/// permutation of the ascending one; the two tetrahedra at a face have different `odd`.
struct FaceKey {
  std::array<GlobalId, 3> gid{kNoGlobal, kNoGlobal, kNoGlobal};
  bool odd = false;
};
constexpr FaceKey face_key(GlobalId a, GlobalId b, GlobalId c) noexcept {
  bool odd = false;
  if (b < a) std::swap(a, b), odd = !odd;
  if (c < b) std::swap(b, c), odd = !odd;
  if (b < a) std::swap(a, b), odd = !odd;
  return {{a, b, c}, odd};
}
inline FaceKey face_key(const TetMesh& m, const IdVector<VertId, GlobalId>& vert2gid, FaceId f) noexcept {
  const auto v = m.verts(f);
  return face_key(vert2gid[v[0]], vert2gid[v[1]], vert2gid[v[2]]);
}
constexpr Rank meeting_rank(const std::array<GlobalId, 3>& gid, int ranks) noexcept {
  return meeting_rank(hash_of(gid), ranks);
}

/// Numbers global ids 0, 1, ... in the order of their first insertion. A hash table with open addressing, or a plain
/// array with a place for each possible id where that takes little more memory.
class GidMap {
 public:
  /// @pre ids are below `total` if that is given.
  explicit GidMap(std::size_t expected, std::int64_t total = 0);
  /// The number of g, a new one if it is not there.
  VertId insert(GlobalId g);
  /// kNoVert when g is not there.
  [[nodiscard]] VertId find(GlobalId g) const noexcept;
  [[nodiscard]] const std::vector<GlobalId>& gids() const noexcept { return gids_; }
  [[nodiscard]] std::size_t size() const noexcept { return gids_.size(); }

 private:
  void grow();
  VertId put(std::size_t slot, GlobalId g);
  std::vector<GlobalId> gids_;
  std::vector<std::int32_t> table_;  ///< number, or -1; the size is a power of two unless direct
  bool direct_;                      ///< the place of an id is the id
};

}  // namespace skein
