// A tree of boxes over triangles, which finds the nearest one to a point.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.hpp"
#include "base/vec3.hpp"

namespace skein {

/// The nearest point of a triangle.
struct NearestPoint {
  double distance2 = 0;
  std::array<double, 3> weight{};  ///< barycentric coordinates, none negative, sum 1
};
NearestPoint nearest_on_triangle(Vec3 x, Vec3 a, Vec3 b, Vec3 c) noexcept;

/// Boxes over triangles, halved along the longest side. About log2(n) boxes are looked at for a point near the surface.
class SurfaceTree {
 public:
  using Triangle = std::array<std::int32_t, 3>;
  SurfaceTree() = default;
  SurfaceTree(std::span<const Vec3> points, std::span<const Triangle> triangles);
  /// The nearest triangle among those that fits(t) allows, of equally near ones the lowest; -1: none.
  template <class Fits>
  [[nodiscard]] std::int32_t nearest(std::span<const Vec3> points, std::span<const Triangle> triangles, Vec3 x,
                                     Fits&& fits) const;

 private:
  struct Node {
    Box box;
    std::int32_t first = 0, count = 0;  ///< of a leaf: in order_; of another node: its children are first, first + 1
    [[nodiscard]] bool is_leaf() const noexcept { return count > 0; }
  };
  void build(std::size_t node, std::span<const Vec3> centres, std::span<const Box> boxes, std::int32_t first,
             std::int32_t count);
  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;
};

template <class Fits>
std::int32_t SurfaceTree::nearest(std::span<const Vec3> points, std::span<const Triangle> triangles, Vec3 x,
                                  Fits&& fits) const {
  struct Waiting {
    double distance2;
    std::int32_t node;
  };
  std::array<Waiting, 128> stack;  // two per level at most
  std::size_t n = 0;
  if (!nodes_.empty()) stack[n++] = {distance2(nodes_.front().box, x), 0};
  std::int32_t best = -1;
  double least = std::numeric_limits<double>::infinity();
  while (n > 0) {
    const auto [apart2, at] = stack[--n];
    if (apart2 > least) continue;
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    if (node.is_leaf()) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const std::int32_t t = order_[static_cast<std::size_t>(i)];
        if (!fits(t)) continue;
        const auto& v = triangles[static_cast<std::size_t>(t)];
        const auto p = [&](std::size_t k) { return points[static_cast<std::size_t>(v[k])]; };
        const double d2 = nearest_on_triangle(x, p(0), p(1), p(2)).distance2;
        if (d2 < least || (d2 == least && t < best)) least = d2, best = t;
      }
      continue;
    }
    Waiting left{distance2(nodes_[static_cast<std::size_t>(node.first)].box, x), node.first};
    Waiting right{distance2(nodes_[static_cast<std::size_t>(node.first) + 1].box, x), node.first + 1};
    if (left.distance2 < right.distance2) std::swap(left, right);
    stack[n++] = left;
    stack[n++] = right;
  }
  return best;
}

}  // namespace skein
