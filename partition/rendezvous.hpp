// Rendezvous: ranks that hold copies of one thing meet at a rank that follows from the thing's global ids alone.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "comm/exchange.hpp"
#include "mesh/ids.hpp"
#include "mesh/radix_sort.hpp"
#include "mesh/tet_mesh.hpp"

namespace skein {

/// Well-mixed bits of a number (finaliser of SplitMix64, S. Vigna).
constexpr std::uint64_t mix(std::uint64_t x) noexcept {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}
constexpr std::uint64_t mix(GlobalId g) noexcept { return mix(static_cast<std::uint64_t>(num(g))); }
/// The rank where the holders of `hash` meet.
constexpr Rank meeting_rank(std::uint64_t hash, int ranks) noexcept {
  return to_id<Rank>((hash >> 16) % static_cast<std::uint64_t>(ranks));
}
constexpr Rank meeting_rank(GlobalId g, int ranks) noexcept { return meeting_rank(mix(g), ranks); }

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
  const auto v = face_verts(m, f);
  return face_key(vert2gid[v[0]], vert2gid[v[1]], vert2gid[v[2]]);
}
constexpr Rank meeting_rank(const std::array<GlobalId, 3>& gid, int ranks) noexcept {
  return meeting_rank(
      mix(mix(mix(gid[0]) ^ static_cast<std::uint64_t>(num(gid[1]))) ^ static_cast<std::uint64_t>(num(gid[2]))), ranks);
}

/// Global ids numbered 0, 1, ... in the order of their first insertion: open addressing, or a place for each id where
/// that takes not much more.
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

/// Collective. exchange() of vectors.
template <Sendable T>
Packets<T> exchange_items(const Comm& comm, const std::vector<Rank>& dest, const std::vector<T>& items) {
  return exchange(comm, std::span<const Rank>(dest), std::span<const T>(items));
}

/// Questions to other ranks; answers come back in the order of the questions.
template <Sendable Q>
class Inquiry {
 public:
  /// Collective. Sends each question to its rank.
  Inquiry(const Comm& comm, const std::vector<Rank>& dest, const std::vector<Q>& questions) : comm_(&comm) {
    std::vector<std::uint32_t> place(questions.size());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<std::uint32_t>(i);
    sent_ = pack(std::span<const Rank>(dest), std::span<const Q>(questions));
    order_ = pack(std::span<const Rank>(dest), std::span<const std::uint32_t>(place)).items;
    asked_ = exchange(comm, sent_);
  }
  /// The questions to this rank, in blocks by source rank.
  [[nodiscard]] const Packets<Q>& asked() const noexcept { return asked_; }
  /// Collective. answers: `width` values for each of asked().items. Gives `width` values per question.
  template <Sendable A>
  [[nodiscard]] std::vector<A> answer(const std::vector<A>& answers, std::size_t width = 1) const {
    Packets<A> back;
    back.rank = asked_.rank;
    back.offset = asked_.offset;
    for (auto& o : back.offset) o *= width;
    back.items = answers;
    const Packets<A> got = exchange(*comm_, back);
    std::vector<A> out(order_.size() * width);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      for (std::size_t c = 0; c < width; ++c) out[order_[i] * width + c] = got.items[i * width + c];
    }
    return out;
  }

 private:
  const Comm* comm_;
  Packets<Q> sent_, asked_;
  std::vector<std::uint32_t> order_;
};

}  // namespace skein
