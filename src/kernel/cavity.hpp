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
  /// Takes old tetrahedra gathered (and stamped with the current Part::tet_stamp) by gather_ball into old_tets().
  void adopt_stamp() noexcept { stamp_ = part_->tet_stamp; }
  std::vector<TetId>& old_tets() noexcept { return old_; }
  void remove_at(std::size_t i) noexcept;

  /// Forgets the new tetrahedra and walls, keeps the old ones.
  void clear_new() noexcept;
  /// Proposes a tetrahedron. False (and nothing proposed) when its quality is not above `floor_q3` or it is not
  /// positive (exact).
  bool propose(VertId a, VertId b, VertId c, VertId d, std::int32_t ref, double floor_q3);
  /// Declares a tagged face that the new tetrahedra form in place of old tagged ones. A hull face may also be a face of
  /// the cavity's border; then the tetrahedron behind that gets it.
  void wall(VertId a, VertId b, VertId c, FaceTag tag);

  [[nodiscard]] double new_min_q3() const noexcept { return new_min_; }
  [[nodiscard]] double old_min_q3() const noexcept;
  [[nodiscard]] std::size_t new_size() const noexcept { return fresh_.size(); }

  /// Replaces the old tetrahedra by the new ones: links them with each other, with the outside and with the walls. New
  /// ones are dirty for all passes. @pre the new tetrahedra fill the old ones' space.
  void commit();
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
  TetId take_slot(std::size_t i);
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
