// Spacing sources: point, line and triangle sources of the chapter [HassanProbert1999, eq. 35.2].
#pragma once
#include <array>
#include <vector>

#include "base/vec3.hpp"

namespace skein {

/// delta(x) = spacing for d < r1, spacing * exp(|ln 2 (d - r1)/(r2 - r1)|) beyond, so that it doubles at d = r2
/// [eq. 35.2]. d is the distance to the point (1 corner), line segment (2) or triangle (3).
struct Source {
  int corners = 1;
  std::array<Vec3, 3> corner;
  double spacing = 1, r1 = 0, r2 = 1;  ///< length; @pre spacing > 0, 0 <= r1 < r2
};

/// The strictest of its sources and of a largest size.
struct SpacingField {
  std::vector<Source> sources;
  double size_max = 1e300;
  [[nodiscard]] double at(Vec3 x) const noexcept;  ///< length
};

/// Distance of x to the source's point, segment or triangle.
double distance(const Source& s, Vec3 x) noexcept;

}  // namespace skein
