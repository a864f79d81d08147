// Cavity: the one way in which topology changes. Old tetrahedra are named, new ones proposed and judged without
// changing anything, then committed together.
#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "kernel/cone.hpp"
#include "kernel/part.hpp"
#include "kernel/shell.hpp"

namespace skein {

/// A face between a cavity and what stays.
struct BorderFace {
  std::array<VertId, 3> v;  ///< counter-clockwise seen from outside the cavity
  FaceId behind;
  std::uint32_t old;  ///< position in the cavity's old tetrahedra
  std::int32_t ref;
  FaceTag tag;
  EdgeBits edges;  ///< of the face, as they will be in a new tetrahedron (apex, v0, v1, v2)
};

/// A triangle between the ring vertices i < k < j of a shell, and the Q^3 of its tetrahedra with the ends of the edge.
struct RingTriangle {
  int i, k, j;
  double with_b, with_a;
};

/// A set of old tetrahedra and the new ones that shall fill the same space. All scratch is reused between operations.
class Cavity {
 public:
  explicit Cavity(Part& part);

  /// Forgets everything; starts a new stamp.
  void clear() noexcept;
  /// Adds an old tetrahedron.
  void add(TetId t);
  [[nodiscard]] bool contains(TetId t) const noexcept { return part_->tet_mark[t] == stamp_; }
  /// Remembers until clear() that t has been met; true the first time, and never for what is in the set.
  bool meet(TetId t) noexcept {
    std::uint32_t& mark = part_->tet_mark[t];
    const bool first = mark < stamp_ - 1;
    mark = std::max(mark, stamp_ - 1);
    return first;
  }
  std::vector<TetId>& old_tets() noexcept { return old_; }
  void remove_at(std::size_t i) noexcept;

  /// Forgets the new tetrahedra and walls, keeps the old ones.
  void clear_new() noexcept;
  /// Q^3 of a tetrahedron; 0 where it is not positive (exact).
  [[nodiscard]] double judge(VertId a, VertId b, VertId c, VertId d) const noexcept;
  /// Proposes a tetrahedron. False (and nothing proposed) when its quality is not above `floor_q3` or it is not
  /// positive (exact).
  bool propose(VertId a, VertId b, VertId c, VertId d, std::int32_t ref, double floor_q3);
  /// The same for one that has been judged already.
  void accept(VertId a, VertId b, VertId c, VertId d, std::int32_t ref, double q3) {
    fresh_.push_back({{a, b, c, d}, ref, static_cast<float>(q3)});
  }
  /// Declares a tagged face that the new tetrahedra form in place of old tagged ones. A hull face may also be a face of
  /// the cavity's border; then the tetrahedron behind that gets it.
  void wall(VertId a, VertId b, VertId c, FaceTag tag);

  [[nodiscard]] double new_min_q3() const noexcept { return new_min_; }
  [[nodiscard]] double old_min_q3() const noexcept;
  /// Sums of inverse_sixth_power().
  [[nodiscard]] double old_sum() const noexcept;
  [[nodiscard]] double new_sum() const noexcept;
  [[nodiscard]] std::size_t new_size() const noexcept { return fresh_.size(); }

  /// Replaces the old tetrahedra by the new ones: links them with each other, with the outside and with the walls. New
  /// ones are dirty for all passes. @pre the new tetrahedra fill the old ones' space.
  void commit();
  /// The same for a cavity without walls whose new tetrahedra all have the apex: one on each face of the border, judged
  /// by `cone` in the same order. `link`: the border's vertices, with Part::edge_class of the edges from the apex to
  /// them. @pre link.size() <= kMaxLink.
  void commit_cone(VertId apex, std::span<const BorderFace> border, const Cone& cone, std::span<const VertId> link);
  static constexpr std::size_t kMaxLink = 64;
  /// The same for the shell of an edge that goes, closed and without tagged faces at the edge: the old tetrahedra, in
  /// order, are the shell's, the new ones lie on both sides of the triangles. A triangle comes before those beyond its
  /// edges (i, k) and (k, j). @pre shell.n <= kMaxRing.
  void commit_ring(const Shell& shell, std::span<const RingTriangle> triangles);
  static constexpr int kMaxRing = 9;
  /// The tetrahedra that the last commit made.
  [[nodiscard]] const std::vector<TetId>& new_tets() const noexcept { return slots_; }

 private:
  struct Fresh {
    std::array<VertId, 4> v;
    std::int32_t ref;
    float q3;
  };
  struct Entry {
    VertId a, b, c;
    std::uint32_t stamp = 0;
    FaceId face;
    FaceTag tag;
    bool open;  ///< a face of a new tetrahedron, or a wall, waiting for its other side
  };
  Entry& lookup(VertId a, VertId b, VertId c) noexcept;
  void enter_outer_faces();
  /// The slot of the i-th new tetrahedron: the old ones' first.
  TetId take_slot(std::size_t i);
  void link_behind(TetId t, std::size_t side, FaceId behind, FaceTag tag) noexcept;
  /// The new tetrahedra are at these vertices where bodies touch.
  void note_contacts();
  /// Gives back the old ones' slots from the number `used` on.
  void free_rest(std::size_t used);
  void link(TetId t);

  Part* part_;
  std::uint32_t stamp_ = 0;
  std::vector<TetId> old_;
  std::vector<Fresh> fresh_;
  std::vector<TetId> slots_;
  struct Wall {
    VertId a, b, c;
    FaceTag tag;
  };
  std::vector<Wall> walls_;
  double new_min_ = 1;
  std::vector<Entry> table_;
  std::uint32_t table_stamp_ = 0;
  std::size_t table_mask_ = 0;
  std::vector<FaceId> mates_;  ///< of commit_cone: kMaxLink rows
};

}  // namespace skein
