// The exact fallback of the orientation predicate.
#include "mesh/predicates.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace skein {

int orient3d_exact(Vec3 a, Vec3 b, Vec3 c, Vec3 d) noexcept {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  const auto p = [](Vec3 v) { return Kernel::Point_3(v.x, v.y, v.z); };
  return static_cast<int>(CGAL::orientation(p(a), p(b), p(c), p(d)));
}

}  // namespace skein
