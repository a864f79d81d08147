// Spacing of point, line and triangle sources [35.2.2.2].
#include "metric/spacing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

double segment_distance(Vec3 a, Vec3 b, Vec3 x) noexcept {
  const Vec3 d = b - a;
  const double length2 = dot(d, d);
  const double t = length2 > 0 ? std::clamp(dot(x - a, d) / length2, 0.0, 1.0) : 0.0;
  return norm(x - (a + t * d));
}

/// The plane's distance when x projects into the triangle, else that of the nearest side; a flat triangle has only
/// sides.
double triangle_distance(Vec3 a, Vec3 b, Vec3 c, Vec3 x) noexcept {
  const Vec3 n = cross(b - a, c - a);
  const double area = norm(n);
  if (area > 0 && dot(cross(b - a, x - a), n) >= 0 && dot(cross(c - b, x - b), n) >= 0 &&
      dot(cross(a - c, x - c), n) >= 0) {
    return std::abs(dot(x - a, n)) / area;
  }
  return std::min({segment_distance(a, b, x), segment_distance(b, c, x), segment_distance(c, a, x)});
}

}  // namespace

double distance(const Source& s, Vec3 x) noexcept {
  switch (s.corners) {
    case 1:
      return norm(x - s.corner[0]);
    case 2:
      return segment_distance(s.corner[0], s.corner[1], x);
    default:
      return triangle_distance(s.corner[0], s.corner[1], s.corner[2], x);
  }
}

double SpacingField::at(Vec3 x) const noexcept {
  double size = size_max;
  for (const Source& s : sources) {
    if (s.spacing >= size) continue;  // a source nowhere asks for less than its spacing
    const double d = distance(s, x);
    const double spacing = d < s.r1 ? s.spacing : s.spacing * std::exp(std::numbers::ln2 * (d - s.r1) / (s.r2 - s.r1));
    size = std::min(size, spacing);
  }
  return size;
}

}  // namespace skein
