// Cavity: the one way in which topology changes. Old tetrahedra are named, new ones proposed and judged without
// changing anything, then committed together.
#pragma once
#include <array>
#include <vector>

#include "kernel/part.hpp"

namespace skein {

/// A set of old tetrahedra and the new ones that shall fill the same space. All scratch is reused between operations.
class Cavity {
 public:
  explicit Cavity(Part& part);

  /// Forgets everything; starts a new stamp.
  void clear() noexcept;
  /// Adds an old tetrahedron.
  void add(TetId t);
  [[nodiscard]] bool contains(TetId t) const noexcept { return part_->tet_mark[t] == stamp_; }
  /// Remembers until clear() that t does not belong here; is_known is true for what is in the set or remembered so.
  void mark_outside(TetId t) noexcept { part_->tet_mark[t] = stamp_ - 1; }
  [[nodiscard]] bool is_known(TetId t) const noexcept { return part_->tet_mark[t] >= stamp_ - 1; }
  std::vector<TetId>& old_tets() noexcept { return old_; }
  void remove_at(std::size_t i) noexcept;

  /// Forgets the new tetrahedra and walls, keeps the old ones.
  void clear_new() noexcept;
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
  [[nodiscard]] std::size_t new_size() const noexcept { return fresh_.size(); }

  /// Replaces the old tetrahedra by the new ones: links them with each other, with the outside and with the walls. New
  /// ones are dirty for all passes. @pre the new tetrahedra fill the old ones' space.
  void commit();
  /// For those who link new tetrahedra themselves: the i-th new one's slot (the old ones' first), and what remains of
  /// the old ones after `used` of them.
  TetId take_slot(std::size_t i);
  void free_rest(std::size_t used);
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
};

}  // namespace skein
