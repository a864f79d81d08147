// A tree of boxes over things that lie in space order: which may contain a point, which are near it.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/box.hpp"
#include "base/vec3.hpp"

namespace skein {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Boxes of boxes: four consecutive ones become one of the next level. No pointers; it is fast when consecutive boxes
/// lie near each other (along a space-filling curve), and right in any order.
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::vector<Box> leaves);

  [[nodiscard]] bool empty() const noexcept { return level_.empty(); }
  /// The boxes of the lowest level that has at most `most` of them.
  [[nodiscard]] std::vector<Box> level_of_at_most(std::size_t most) const;

  /// Calls visit(leaf number) for leaves whose box contains x, ascending, until it returns true.
  template <class Visit>
  void containing(Vec3 x, Visit&& visit) const;
  /// Calls visit(leaf number, squared distance of its box) for leaves that are not farther than the root of `limit2`,
  /// roughly the nearest first; visit may lower limit2.
  template <class Visit>
  void near(Vec3 x, double& limit2, Visit&& visit) const;

 private:
  static constexpr std::size_t kFan = 4;
  static constexpr std::size_t kStack = 80;  ///< 3 per level and one more; 20 levels hold 10^12 leaves
  struct Node {
    std::uint32_t level, index;
    double distance2;
  };
  std::vector<std::vector<Box>> level_;  ///< the leaves first, one box last
};

template <class Visit>
void BoxTree::containing(Vec3 x, Visit&& visit) const {
  if (empty()) return;
  std::array<Node, kStack> stack;
  std::size_t top = 0;
  if (contains(level_.back()[0], x)) stack[top++] = {static_cast<std::uint32_t>(level_.size() - 1), 0, 0};
  while (top > 0) {
    const Node n = stack[--top];
    if (n.level == 0) {
      if (visit(std::size_t{n.index})) return;
      continue;
    }
    const auto& below = level_[n.level - 1];
    const std::size_t first = kFan * n.index, last = std::min(first + kFan, below.size());
    for (std::size_t i = last; i-- > first;) {
      if (contains(below[i], x)) stack[top++] = {n.level - 1, static_cast<std::uint32_t>(i), 0};
    }
  }
}

template <class Visit>
void BoxTree::near(Vec3 x, double& limit2, Visit&& visit) const {
  if (empty()) return;
  std::array<Node, kStack> stack;
  std::size_t top = 0;
  stack[top++] = {static_cast<std::uint32_t>(level_.size() - 1), 0, skein::distance2(level_.back()[0], x)};
  while (top > 0) {
    const Node n = stack[--top];
    if (n.distance2 > limit2) continue;
    if (n.level == 0) {
      visit(std::size_t{n.index}, n.distance2);
      continue;
    }
    const auto& below = level_[n.level - 1];
    const std::size_t first = kFan * n.index, last = std::min(first + kFan, below.size()), old_top = top;
    for (std::size_t i = first; i < last; ++i) {
      Node child{n.level - 1, static_cast<std::uint32_t>(i), skein::distance2(below[i], x)};
      if (child.distance2 > limit2) continue;
      std::size_t at = top++;  // the nearest on top, of equal ones the first
      for (; at > old_top && stack[at - 1].distance2 <= child.distance2; --at) stack[at] = stack[at - 1];
      stack[at] = child;
    }
  }
}

}  // namespace skein
