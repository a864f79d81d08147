// Positions along a 3D Hilbert curve: points near on the curve are near in space.
#pragma once
#include <cstdint>

#include "mesh/vec3.hpp"

namespace skein {

/// Axis-parallel box.
struct Box {
  Vec3 low, high;
};

/// Position of x on the Hilbert curve through the box: 63 bits, 21 per axis. Points outside are moved to its border.
/// (C. H. Hamilton, A. Rau-Chaplin, Compact Hilbert indices, Inf. Process. Lett. 105, 2008: the curve by Gray codes,
/// entry corners and directions; here tabulated.)
std::uint64_t hilbert_key(Vec3 x, const Box& box) noexcept;

}  // namespace skein
