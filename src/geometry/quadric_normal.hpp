// The normal of a surface at one of its points, from points round it.
#pragma once
#include <span>

#include "base/vec3.hpp"

namespace skein {

/// The unit normal at the point v of a surface through v and the `points`. The quadric (an implicit surface of second
/// degree) through v that misses the points least is fitted; its gradient is the normal. So the result is exact for
/// planes, spheres, cylinders, cones, ellipsoids. `guess` is a rough unit normal: where several quadrics fit, the
/// normal that is nearest to it is taken, and where the fit differs from it by more than 30 degrees (points that are of
/// no such surface), `guess` itself.
Vec3 quadric_normal(Vec3 v, std::span<const Vec3> points, Vec3 guess);

}  // namespace skein
