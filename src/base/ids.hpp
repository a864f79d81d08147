// Typed identifiers. Every index that crosses a header is one of these; a map is named a2b (vert2tet).
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/assert.hpp"

namespace skein {

enum class VertId : std::int32_t {};    ///< vertex, local to a rank or a part
enum class TetId : std::int32_t {};     ///< tetrahedron, local to a rank or a part
enum class FaceId : std::int32_t {};    ///< 4*tet + face; face f is opposite to the tetrahedron's vertex f
enum class GlobalId : std::int64_t {};  ///< vertex number, the same on every rank
enum class Rank : std::int32_t {};      ///< MPI rank
enum class PartId : std::int32_t {};    ///< part of a partition; part p goes to rank p

inline constexpr VertId kNoVert{-1};
inline constexpr TetId kNoTet{-1};
inline constexpr FaceId kNoFace{-1};
inline constexpr GlobalId kNoGlobal{-1};
inline constexpr PartId kNoPart{-1};

template <class Id>
concept Identifier = std::is_enum_v<Id>;

/// The identifier as an array index.
template <Identifier Id>
constexpr std::size_t idx(Id i) noexcept {
  return static_cast<std::size_t>(i);
}
/// The identifier as its integer (signed; -1 is "none").
template <Identifier Id>
constexpr std::underlying_type_t<Id> num(Id i) noexcept {
  return static_cast<std::underlying_type_t<Id>>(i);
}
template <Identifier Id, class Int>
constexpr Id to_id(Int i) noexcept {
  return static_cast<Id>(static_cast<std::underlying_type_t<Id>>(i));
}

/// The part that belongs to a rank, and the rank that a part belongs to.
constexpr PartId part_of(Rank r) noexcept { return PartId{num(r)}; }
constexpr Rank rank_of(PartId p) noexcept { return Rank{num(p)}; }

constexpr TetId face_tet(FaceId f) noexcept { return TetId{num(f) >> 2}; }
constexpr std::size_t face_side(FaceId f) noexcept { return static_cast<std::size_t>(num(f) & 3); }
constexpr FaceId make_face(TetId t, std::size_t side) noexcept {
  return FaceId{num(t) * 4 + static_cast<std::int32_t>(side)};
}

/// A std::vector that can be indexed only by its own identifier type. Heavy assertions check every index.
template <Identifier Id, class T>
class IdVector {
 public:
  IdVector() = default;
  explicit IdVector(std::size_t n) : data_(n) {}
  IdVector(std::size_t n, const T& v) : data_(n, v) {}
  explicit IdVector(std::vector<T> v) : data_(std::move(v)) {}

  T& operator[](Id i) noexcept {
    SKEIN_ASSERT_HEAVY(idx(i) < data_.size());
    return data_[idx(i)];
  }
  const T& operator[](Id i) const noexcept {
    SKEIN_ASSERT_HEAVY(idx(i) < data_.size());
    return data_[idx(i)];
  }
  [[nodiscard]] std::size_t size() const noexcept { return data_.size(); }
  [[nodiscard]] bool empty() const noexcept { return data_.empty(); }
  /// The identifier that the next push_back gets.
  [[nodiscard]] Id end_id() const noexcept { return to_id<Id>(data_.size()); }
  Id push_back(const T& v) {
    data_.push_back(v);
    return to_id<Id>(data_.size() - 1);
  }
  void resize(std::size_t n) { data_.resize(n); }
  void resize(std::size_t n, const T& v) { data_.resize(n, v); }
  void assign(std::size_t n, const T& v) { data_.assign(n, v); }
  void reserve(std::size_t n) { data_.reserve(n); }
  [[nodiscard]] std::size_t capacity() const noexcept { return data_.capacity(); }
  void clear() noexcept { data_.clear(); }
  void shrink_to_fit() { data_.shrink_to_fit(); }
  T* data() noexcept { return data_.data(); }
  const T* data() const noexcept { return data_.data(); }
  auto begin() noexcept { return data_.begin(); }
  auto end() noexcept { return data_.end(); }
  auto begin() const noexcept { return data_.begin(); }
  auto end() const noexcept { return data_.end(); }
  T& back() noexcept { return data_.back(); }
  std::vector<T>& raw() noexcept { return data_; }
  const std::vector<T>& raw() const noexcept { return data_; }
  friend bool operator==(const IdVector&, const IdVector&) = default;

 private:
  std::vector<T> data_;
};

/// Half-open range of identifiers, for range-based for.
template <Identifier Id>
class IdRange {
 public:
  constexpr explicit IdRange(std::size_t n) noexcept : first_(0), n_(n) {}
  constexpr IdRange(std::size_t first, std::size_t n) noexcept : first_(first), n_(n) {}
  struct It {
    std::size_t i;
    constexpr Id operator*() const noexcept { return to_id<Id>(i); }
    constexpr It& operator++() noexcept {
      ++i;
      return *this;
    }
    constexpr bool operator!=(const It& o) const noexcept { return i != o.i; }
  };
  [[nodiscard]] constexpr It begin() const noexcept { return {first_}; }
  [[nodiscard]] constexpr It end() const noexcept { return {n_}; }

 private:
  std::size_t first_, n_;
};

}  // namespace skein
