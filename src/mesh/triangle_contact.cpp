// Tests of two triangles with a tolerance.
#include "mesh/triangle_contact.hpp"

#include <algorithm>
#include <cmath>

namespace skein {
namespace {

constexpr double kShareOfEdge = 1e-10, kRoundings = 4 * 2.2e-16;

/// Heights above the plane of `a` of the vertices of `b`; exactly 0 for those that both have.
std::array<double, 3> heights(const ContactTriangle& a, const ContactTriangle& b) noexcept {
  std::array<double, 3> h{};
  for (std::size_t k = 0; k < 3; ++k) {
    const bool common = std::find(a.gid.begin(), a.gid.end(), b.gid[k]) != a.gid.end();
    h[k] = common ? 0 : dot(a.normal, b.x[k] - a.x[0]);
  }
  return h;
}
/// True when `b` can touch `a` in common vertices only.
bool one_side(const ContactTriangle& a, const ContactTriangle& b, const std::array<double, 3>& h, double tol) noexcept {
  int above = 0, below = 0, common = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::find(a.gid.begin(), a.gid.end(), b.gid[k]) != a.gid.end()) {
      ++common;
    } else {
      above += h[k] > tol ? 1 : 0;
      below += h[k] < -tol ? 1 : 0;
    }
  }
  return above + common == 3 || below + common == 3;
}
bool is_flat(const std::array<double, 3>& h, double tol) noexcept {
  return std::ranges::all_of(h, [&](double z) { return std::abs(z) <= tol; });
}

/// The least distance of p, in the plane of t, to the lines through its edges; negative outside.
double depth(const ContactTriangle& t, Vec3 p) noexcept {
  double least = dot(t.in[0], p - t.x[1]);
  for (std::size_t k = 1; k < 3; ++k) least = std::min(least, dot(t.in[k], p - t.x[(k + 1) % 3]));
  return least;
}

/// True when a line through an edge of `a` has all of `b` beyond it.
bool edge_separates(const ContactTriangle& a, const ContactTriangle& b, double tol) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 foot = a.x[(k + 1) % 3];
    if (std::ranges::all_of(b.x, [&](Vec3 p) { return dot(a.in[k], p - foot) <= tol; })) return true;
  }
  return false;
}

/// True when an edge of `b`, whose heights above `a` are h, goes through the inside of `a`.
bool goes_through(const ContactTriangle& a, const ContactTriangle& b, const std::array<double, 3>& h,
                  double tol) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t l = (k + 1) % 3;
    if (!((h[k] > tol && h[l] < -tol) || (h[k] < -tol && h[l] > tol))) continue;
    const Vec3 p = b.x[k] + h[k] / (h[k] - h[l]) * (b.x[l] - b.x[k]);
    if (depth(a, p) > tol) return true;
  }
  return false;
}

bool at_vertex_of(const ContactTriangle& t, Vec3 p, double tol) noexcept {
  return std::ranges::any_of(t.x, [&](Vec3 x) { return norm(x - p) <= 2 * tol; });
}

/// A vertex of `b` inside of `a` or of an edge of it, at no vertex of it; kNoGlobal if there is none.
GlobalId find_hanging(const ContactTriangle& a, const ContactTriangle& b, const std::array<double, 3>& h,
                      double tol) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::abs(h[k]) > tol || std::find(a.gid.begin(), a.gid.end(), b.gid[k]) != a.gid.end()) continue;
    if (depth(a, b.x[k]) >= -tol && !at_vertex_of(a, b.x[k], tol)) return b.gid[k];
  }
  return kNoGlobal;
}

bool same_places(const ContactTriangle& a, const ContactTriangle& b, double tol) noexcept {
  return std::ranges::all_of(a.x, [&](Vec3 p) { return at_vertex_of(b, p, tol); }) &&
         std::ranges::all_of(b.x, [&](Vec3 p) { return at_vertex_of(a, p, tol); });
}

}  // namespace

ContactTriangle contact_triangle(const std::array<GlobalId, 3>& gid, const std::array<Vec3, 3>& x) noexcept {
  ContactTriangle t;
  t.gid = gid, t.x = x;
  t.normal = normalized(cross(x[1] - x[0], x[2] - x[0]));
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 edge = x[(k + 2) % 3] - x[(k + 1) % 3];
    t.longest = std::max(t.longest, norm(edge));
    t.in[k] = normalized(cross(t.normal, edge));
  }
  t.box = bounding_box(t.x);
  return t;
}

double contact_tolerance(const ContactTriangle& a, const ContactTriangle& b) noexcept {
  double far = 0;
  for (const Vec3 p : {a.box.low, a.box.high, b.box.low, b.box.high}) {
    far = std::max({far, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  return kShareOfEdge * std::max(a.longest, b.longest) + kRoundings * far;
}

ContactResult contact_of(const ContactTriangle& a, const ContactTriangle& b) noexcept {
  const double tol = contact_tolerance(a, b);
  const auto b_over_a = heights(a, b);
  if (one_side(a, b, b_over_a, tol)) return {};
  const auto a_over_b = heights(b, a);
  if (one_side(b, a, a_over_b, tol)) return {};
  // Too narrow for its own tolerance: nothing can be said.
  if (depth(a, 1.0 / 3 * (a.x[0] + a.x[1] + a.x[2])) <= tol || depth(b, 1.0 / 3 * (b.x[0] + b.x[1] + b.x[2])) <= tol)
    return {};
  const bool flat = is_flat(b_over_a, tol) || is_flat(a_over_b, tol);
  if (flat && same_places(a, b, tol)) return {Contact::kMatching, kNoGlobal};
  GlobalId hanging = find_hanging(a, b, b_over_a, tol);
  if (hanging == kNoGlobal) hanging = find_hanging(b, a, a_over_b, tol);
  if (hanging != kNoGlobal) return {Contact::kHanging, hanging};
  if (flat) {
    const bool apart = edge_separates(a, b, tol) || edge_separates(b, a, tol);
    return {apart ? Contact::kNone : Contact::kCovering, kNoGlobal};
  }
  const bool through = goes_through(a, b, b_over_a, tol) || goes_through(b, a, a_over_b, tol);
  return {through ? Contact::kCrossing : Contact::kNone, kNoGlobal};
}

}  // namespace skein
