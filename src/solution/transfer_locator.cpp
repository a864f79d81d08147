// Locating points among tetrahedra.
#include "solution/transfer_locator.hpp"

#include <algorithm>

namespace skein {
namespace {

constexpr std::size_t kLeaf = 4;  ///< tetrahedra per leaf of the tree
constexpr int kLongestWalk = 96;  ///< tetrahedra; a longer walk costs more than the tree
constexpr double kLost = -1e300;  ///< the weights of a tetrahedron that has no volume in floating point

double least(const std::array<double, 4>& w) noexcept { return std::min(std::min(w[0], w[1]), std::min(w[2], w[3])); }

/// Barycentric weights of p in a b c d, relative to a: exactly (1, 0, 0, 0) for p = a.
std::array<double, 4> barycentric(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 p) noexcept {
  const Vec3 u = b - a, v = c - a, w = d - a, q = p - a;
  const Vec3 vw = cross(v, w);
  const double v6 = dot(u, vw);
  if (v6 == 0) return {kLost, kLost, kLost, kLost};
  const double s = 1 / v6, wb = s * dot(q, vw), wc = s * dot(q, cross(w, u)), wd = s * dot(q, cross(u, v));
  return {1 - wb - wc - wd, wb, wc, wd};
}

/// Weights of the point of the segment a b nearest to p.
std::array<double, 2> nearest_on_segment(Vec3 a, Vec3 b, Vec3 p) noexcept {
  const double l2 = dot(b - a, b - a);
  const double t = l2 > 0 ? std::clamp(dot(p - a, b - a) / l2, 0.0, 1.0) : 0;
  return {1 - t, t};
}

/// Weights of the point of the triangle nearest to p: its projection if that lies inside, or a point of an edge.
std::array<double, 3> nearest_on_triangle(const std::array<Vec3, 3>& x, Vec3 p) noexcept {
  const Vec3 u = x[1] - x[0], v = x[2] - x[0], q = p - x[0], n = cross(u, v);
  const double n2 = dot(n, n);
  if (n2 > 0) {
    const double wb = dot(cross(q, v), n) / n2, wc = dot(cross(u, q), n) / n2;
    if (wb >= 0 && wc >= 0 && wb + wc <= 1) return {1 - wb - wc, wb, wc};
  }
  std::array<double, 3> best{};
  double best2 = kInfinity;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const auto w = nearest_on_segment(x[i], x[j], p);
    const Vec3 d = p - x[i] - w[1] * (x[j] - x[i]);
    if (dot(d, d) >= best2) continue;
    best2 = dot(d, d);
    best = {};
    best[i] = w[0], best[j] = w[1];
  }
  return best;
}

}  // namespace

BoxTree::BoxTree(std::vector<Box> leaves) {
  if (leaves.empty()) return;
  level_.push_back(std::move(leaves));
  while (level_.back().size() > 1) {
    const auto& below = level_.back();
    std::vector<Box> above((below.size() + kFan - 1) / kFan, kEmptyBox);
    for (std::size_t i = 0; i < below.size(); ++i) above[i / kFan] = join(above[i / kFan], below[i]);
    level_.push_back(std::move(above));
  }
}

std::vector<Box> BoxTree::level_of_at_most(std::size_t most) const {
  for (const auto& level : level_) {
    if (level.size() <= most) return level;
  }
  return {};
}

TetLocator::TetLocator(const TetMesh& mesh) : coords_(mesh.coords), tet2vert_(mesh.tet2vert), tet2face_(mesh.tet2face) {
  std::vector<Box> leaves((tet2vert_.size() + kLeaf - 1) / kLeaf, kEmptyBox);
  for (const TetId t : IdRange<TetId>(tet2vert_.size())) {
    Box& box = leaves[idx(t) / kLeaf];
    for (const VertId v : tet2vert_[t]) box = join(box, coords_[v]);
  }
  tree_ = BoxTree(std::move(leaves));
}

std::array<double, 4> TetLocator::weights(TetId t, Vec3 x) const noexcept {
  const auto& v = tet2vert_[t];
  return barycentric(coords_[v[0]], coords_[v[1]], coords_[v[2]], coords_[v[3]], x);
}

/// The weights once more, relative to the nearest vertex: there they are exact, so that a vertex that was kept keeps
/// its values bit by bit.
Place TetLocator::place_inside(TetId t, Vec3 x, const std::array<double, 4>& rough) const noexcept {
  const auto k = static_cast<std::size_t>(std::max_element(rough.begin(), rough.end()) - rough.begin());
  const auto& v = tet2vert_[t];
  const auto at = [&](std::size_t i) { return coords_[v[(k + i) % 4]]; };
  const auto w = barycentric(at(0), at(1), at(2), at(3), x);
  Place place{t, {}, 0};
  for (std::size_t i = 0; i < 4; ++i) place.weight[(k + i) % 4] = w[i];
  return place;
}

/// Crosses the face of least weight until no weight is negative. False at the border of the mesh, and when it takes
/// too long.
bool TetLocator::walk(Vec3 x, TetId& t, std::array<double, 4>& w) const noexcept {
  for (int step = 0; step < kLongestWalk; ++step) {
    w = weights(t, x);
    if (least(w) >= -kTolerance) return true;
    FaceId next = kNoFace;
    double lowest = -kTolerance;
    for (std::size_t k = 0; k < 4; ++k) {
      if (w[k] >= lowest || tet2face_[t][k] == kNoFace) continue;
      lowest = w[k];
      next = tet2face_[t][k];
    }
    if (next == kNoFace) return false;
    t = face_tet(next);
  }
  return false;
}

bool TetLocator::find(Vec3 x, TetId& hint, Place& place) const noexcept {
  std::array<double, 4> w{};
  TetId t = hint;
  if (t != kNoTet && walk(x, t, w)) {
    hint = t;
    place = place_inside(t, x, w);
    return true;
  }
  double best = -kTolerance;
  TetId found = kNoTet;
  std::array<double, 4> found_w{};
  tree_.containing(x, [&](std::size_t leaf) {
    const std::size_t last = std::min(kLeaf * (leaf + 1), tet2vert_.size());
    for (std::size_t i = kLeaf * leaf; i < last; ++i) {
      const auto wi = weights(to_id<TetId>(i), x);
      if (least(wi) < best) continue;
      best = least(wi);
      found = to_id<TetId>(i);
      found_w = wi;
    }
    return found != kNoTet && best >= 0;
  });
  if (found == kNoTet) return false;
  hint = found;
  place = place_inside(found, x, found_w);
  return true;
}

/// Puts the point of t nearest to x into `best` if it is nearer. Only faces that x sees from outside matter.
void TetLocator::nearest_in(TetId t, Vec3 x, Place& best) const noexcept {
  const auto w = weights(t, x);
  if (least(w) >= 0) {
    best = {t, w, 0};
    return;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    if (w[k] >= 0) continue;
    const auto& face = kFaceVerts[k];
    std::array<Vec3, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = coords_[tet2vert_[t][face[i]]];
    const auto wf = nearest_on_triangle(corner, x);
    const Vec3 d = x - corner[0] - wf[1] * (corner[1] - corner[0]) - wf[2] * (corner[2] - corner[0]);
    if (dot(d, d) >= best.distance2) continue;
    best = {t, {}, dot(d, d)};
    for (std::size_t i = 0; i < 3; ++i) best.weight[face[i]] = wf[i];
  }
}

Place TetLocator::nearest(Vec3 x, double limit2) const noexcept {
  Place best;
  double limit = limit2;
  tree_.near(x, limit, [&](std::size_t leaf, double) {
    const std::size_t last = std::min(kLeaf * (leaf + 1), tet2vert_.size());
    for (std::size_t i = kLeaf * leaf; i < last; ++i) nearest_in(to_id<TetId>(i), x, best);
    limit = std::min(limit, best.distance2);
  });
  return best.distance2 <= limit2 ? best : Place{};
}

}  // namespace skein
