// Where a vertex of the boundary is on the reference surface.
#pragma once
#include <cstdint>

namespace skein {

/// A triangle of the reference surface (>= 0), a feature edge of it (from -2 downwards), or unknown (-1). The place in
/// there follows from the coordinates of the vertex.
enum class SurfacePlace : std::int32_t { kUnknown = -1 };
constexpr SurfacePlace on_triangle(std::int32_t t) noexcept { return static_cast<SurfacePlace>(t); }
constexpr SurfacePlace on_edge(std::int32_t e) noexcept { return static_cast<SurfacePlace>(-2 - e); }
constexpr bool is_triangle(SurfacePlace p) noexcept { return static_cast<std::int32_t>(p) >= 0; }
constexpr bool is_edge(SurfacePlace p) noexcept { return static_cast<std::int32_t>(p) <= -2; }
constexpr std::int32_t triangle_of(SurfacePlace p) noexcept { return static_cast<std::int32_t>(p); }
constexpr std::int32_t edge_of(SurfacePlace p) noexcept { return -2 - static_cast<std::int32_t>(p); }

}  // namespace skein
