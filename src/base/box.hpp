// Axis-parallel boxes.
#pragma once
#include "base/vec3.hpp"

namespace skein {

/// Axis-parallel box.
struct Box {
  Vec3 low, high;
};

}  // namespace skein
