// Building the tree, and the nearest point of a triangle.
#include "geometry/surface_tree.hpp"

#include <algorithm>
#include <numeric>

namespace skein {
namespace {

constexpr std::int32_t kLeaf = 4;  ///< triangles

double side(const Box& b, int axis) noexcept {
  const Vec3 d = b.high - b.low;
  return axis == 0 ? d.x : axis == 1 ? d.y : d.z;
}
double along(Vec3 x, int axis) noexcept { return axis == 0 ? x.x : axis == 1 ? x.y : x.z; }

NearestPoint at(Vec3 x, const std::array<Vec3, 3>& p, const std::array<double, 3>& w) noexcept {
  const Vec3 d = x - (w[0] * p[0] + w[1] * p[1] + w[2] * p[2]);
  return {dot(d, d), w};
}

/// The nearest point of the side from corner i to corner k.
NearestPoint on_side(Vec3 x, const std::array<Vec3, 3>& p, std::size_t i, std::size_t k) noexcept {
  const Vec3 e = p[k] - p[i];
  const double l2 = dot(e, e), t = l2 > 0 ? std::clamp(dot(x - p[i], e) / l2, 0.0, 1.0) : 0;
  std::array<double, 3> w{};
  w[i] = 1 - t, w[k] = t;
  return at(x, p, w);
}

}  // namespace

NearestPoint nearest_on_triangle(Vec3 x, Vec3 a, Vec3 b, Vec3 c) noexcept {
  const std::array p{a, b, c};
  const Vec3 n = cross(b - a, c - a);
  const double n2 = dot(n, n);
  if (n2 > 0) {
    const double wb = dot(cross(x - a, c - a), n) / n2, wc = dot(cross(b - a, x - a), n) / n2, wa = 1 - wb - wc;
    if (wa >= 0 && wb >= 0 && wc >= 0) return at(x, p, {wa, wb, wc});
  }
  NearestPoint best = on_side(x, p, 0, 1);
  for (const NearestPoint& other : {on_side(x, p, 1, 2), on_side(x, p, 2, 0)}) {
    if (other.distance2 < best.distance2) best = other;
  }
  return best;
}

SurfaceTree::SurfaceTree(std::span<const Vec3> points, std::span<const Triangle> triangles) {
  if (triangles.empty()) return;
  std::vector<Box> boxes;
  std::vector<Vec3> centres;
  boxes.reserve(triangles.size()), centres.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    Box b = kEmptyBox;
    for (const std::int32_t v : t) b = join(b, points[static_cast<std::size_t>(v)]);
    boxes.push_back(b);
    centres.push_back(0.5 * (b.low + b.high));
  }
  order_.resize(triangles.size());
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(triangles.size());
  nodes_.emplace_back();
  build(0, centres, boxes, 0, static_cast<std::int32_t>(triangles.size()));
}

void SurfaceTree::build(std::size_t node, std::span<const Vec3> centres, std::span<const Box> boxes, std::int32_t first,
                        std::int32_t count) {
  Box box = kEmptyBox, inner = kEmptyBox;
  const auto begin = order_.begin() + first;
  for (auto i = begin; i != begin + count; ++i) {
    box = join(box, boxes[static_cast<std::size_t>(*i)]);
    inner = join(inner, centres[static_cast<std::size_t>(*i)]);
  }
  nodes_[node] = {box, first, count};
  if (count <= kLeaf) return;
  int axis = 0;
  for (const int k : {1, 2}) axis = side(inner, k) > side(inner, axis) ? k : axis;
  const std::int32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](std::int32_t a, std::int32_t b) {
    const double xa = along(centres[static_cast<std::size_t>(a)], axis);
    const double xb = along(centres[static_cast<std::size_t>(b)], axis);
    return xa != xb ? xa < xb : a < b;
  });
  const std::size_t child = nodes_.size();
  nodes_[node].first = static_cast<std::int32_t>(child);
  nodes_[node].count = 0;
  nodes_.resize(child + 2);
  build(child, centres, boxes, first, half);
  build(child + 1, centres, boxes, first + half, count - half);
}

}  // namespace skein
