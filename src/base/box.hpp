// Axis-parallel boxes.
#pragma once
#include <algorithm>
#include <limits>
#include <span>

#include "base/vec3.hpp"

namespace skein {

/// Axis-parallel box.
struct Box {
  Vec3 low, high;
};

/// The box of nothing: every join with it gives the other box.
inline constexpr Box kEmptyBox{{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity()},
                               {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()}};

/// The smallest box round both.
constexpr Box join(const Box& a, const Box& b) noexcept {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}
constexpr Box join(const Box& b, Vec3 x) noexcept { return join(b, {x, x}); }
/// The smallest box round all points; kEmptyBox without any.
constexpr Box bounding_box(std::span<const Vec3> points) noexcept {
  Box box = kEmptyBox;
  for (const Vec3 x : points) box = join(box, x);
  return box;
}
/// True for points inside and on the border.
constexpr bool contains(const Box& b, Vec3 x) noexcept {
  return x.x >= b.low.x && x.x <= b.high.x && x.y >= b.low.y && x.y <= b.high.y && x.z >= b.low.z && x.z <= b.high.z;
}
/// Square of the distance of a point to the box, 0 inside.
constexpr double distance2(const Box& b, Vec3 x) noexcept {
  const double dx = std::max({b.low.x - x.x, 0.0, x.x - b.high.x});
  const double dy = std::max({b.low.y - x.y, 0.0, x.y - b.high.y});
  const double dz = std::max({b.low.z - x.z, 0.0, x.z - b.high.z});
  return dx * dx + dy * dy + dz * dz;
}

}  // namespace skein
