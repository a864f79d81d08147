// How two triangles in space touch: for the search of faces that meet without being the same face.
#pragma once
#include <array>
#include <cstdint>

#include "base/box.hpp"
#include "base/ids.hpp"

namespace skein {

/// A triangle with what its tests need, computed once.
struct ContactTriangle {
  std::array<GlobalId, 3> gid{kNoGlobal, kNoGlobal, kNoGlobal};
  std::array<Vec3, 3> x;
  Vec3 normal;             ///< unit; zero for a triangle without area
  std::array<Vec3, 3> in;  ///< in its plane, unit, across the edge opposite to vertex k towards that vertex
  double longest = 0;      ///< edge
  Box box;                 ///< without tolerance
};
ContactTriangle contact_triangle(const std::array<GlobalId, 3>& gid, const std::array<Vec3, 3>& x) noexcept;

/// Distance below which points count as one: a share of the longest edge, and rounding of the coordinates. It is far
/// below the heights of boundary layers, and far above what rotating or printing coordinates changes.
double contact_tolerance(const ContactTriangle& a, const ContactTriangle& b) noexcept;

enum class Contact : std::int32_t {
  kNone,      ///< apart, or together only in vertices and edges that they have in common (by number or by place)
  kHanging,   ///< a vertex of one lies inside the other, or inside an edge of it
  kCovering,  ///< in one plane, overlapping
  kCrossing,  ///< an edge of one goes through the inside of the other
  kMatching,  ///< the same three places
};
struct ContactResult {
  Contact contact = Contact::kNone;
  GlobalId hanging = kNoGlobal;  ///< the vertex, with kHanging
};
/// @pre not the same triangle
ContactResult contact_of(const ContactTriangle& a, const ContactTriangle& b) noexcept;

}  // namespace skein
