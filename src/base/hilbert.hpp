// Positions along a 3D Hilbert curve: points near on the curve are near in space.
#pragma once
#include <cstdint>
#include <span>

#include "base/box.hpp"

namespace skein {

/// Position of x on the Hilbert curve through the box: 63 bits, 21 per axis. Points outside are moved to its border.
/// ([Skilling2004]: transposed form by bit operations.)
std::uint64_t hilbert_key(Vec3 x, const Box& box) noexcept;
/// The same for many points at once, several times faster for each. @pre key is as long as x.
void hilbert_keys(std::span<const Vec3> x, const Box& box, std::span<std::uint64_t> key) noexcept;

}  // namespace skein
