// Edge swapping over the skew polygon (dynamic programming) and face swapping.
#include "kernel/swap.hpp"

#include <algorithm>
#include <numbers>

namespace skein {
bool Swapper::surface_swap_allowed() {
  const TetMesh& m = part_->mesh;
  const FaceTag first = shell_.tag[0], last = shell_.tag[shell_.n];
  if (shell_.n < 2 || first != last || (first & kRequiredFace) != 0 || !part_->options.surface) return false;
  const VertId a = shell_.a, b = shell_.b;
  if (m.has(a, kRidge) && m.has(b, kRidge) && m.features.find(a, b) != nullptr) return false;
  const Vec3 xa = part_->x(a), xb = part_->x(b), x0 = part_->x(shell_.ring[0]), x1 = part_->x(shell_.ring[shell_.n]);
  // Outward normals of the two old and the two new triangles. ring[0] .. ring[n] turns counter-clockwise seen from b,
  // with the domain between; outside of the first face is a, b reversed.
  const Vec3 old0 = cross(xb - xa, x0 - xa), old1 = cross(x1 - xa, xb - xa);
  const Vec3 new0 = cross(x1 - xa, x0 - xa), new1 = cross(x0 - xb, x1 - xb);
  const double min_dot = std::cos(part_->options.surface_angle * std::numbers::pi / 180);
  for (const Vec3& o : {old0, old1}) {
    for (const Vec3& n : {new0, new1}) {
      if (!(dot(o, n) > min_dot * norm(o) * norm(n))) return false;
    }
  }
  const Vec3 e = xb - xa;
  const double height = std::abs(volume6(xa, xb, x0, x1)) / std::max(norm(cross(e, x1 - x0)), 1e-300);
  return height <= part_->options.surface_deviation * std::min(norm(e), norm(x1 - x0));
}

bool Swapper::may_connect(int i, int j) const noexcept {
  if (j - i < 2 || (shell_.closed && j - i == shell_.n - 1)) return true;
  return part_->strain(shell_.ring[i], shell_.ring[j]) < max_strain_;
}

double Swapper::best_triangulation(int ring) {
  const VertId a = shell_.a, b = shell_.b;
  const auto q = [&](int i, int j, int k) {
    const VertId p = shell_.ring[i], r = shell_.ring[j], s = shell_.ring[k];
    const double top = part_->quality_cubed(p, r, s, b);
    if (top <= bound_) return top;
    return std::min(top, part_->quality_cubed(p, s, r, a));
  };
  for (int i = 0; i + 1 < ring; ++i) best_[i][i + 1] = 1;
  for (int len = 2; len < ring; ++len) {
    for (int i = 0; i + len < ring; ++i) {
      const int j = i + len;
      double best = -1;
      int at = i + 1;
      for (int k = i + 1; k < j; ++k) {
        const double sides = std::min(best_[i][k], best_[k][j]);
        if (sides <= std::max(best, bound_)) continue;
        if (max_strain_ < kAnyStrain && !(may_connect(i, k) && may_connect(k, j))) continue;
        const double w = std::min(sides, q(i, k, j));
        if (w > best) {
          best = w;
          at = k;
        }
      }
      best_[i][j] = best;
      split_[i][j] = at;
    }
  }
  return best_[0][ring - 1];
}

double Swapper::lightest_triangulation(int ring) {
  constexpr double kRefused = 1e300;
  const VertId a = shell_.a, b = shell_.b;
  const auto weight = [&](int i, int j, int k) {
    const VertId p = shell_.ring[i], r = shell_.ring[j], s = shell_.ring[k];
    const double top = part_->quality_cubed(p, r, s, b);
    if (top <= bound_) return kRefused;
    const double under = part_->quality_cubed(p, s, r, a);
    return under <= bound_ ? kRefused : inverse_sixth_power(top) + inverse_sixth_power(under);
  };
  for (int i = 0; i + 1 < ring; ++i) best_[i][i + 1] = 0;
  for (int len = 2; len < ring; ++len) {
    for (int i = 0; i + len < ring; ++i) {
      const int j = i + len;
      double best = kRefused;
      int at = i + 1;
      for (int k = i + 1; k < j; ++k) {
        const double sides = best_[i][k] + best_[k][j];
        if (sides >= best) continue;
        const double w = sides + weight(i, k, j);
        if (w < best) best = w, at = k;
      }
      best_[i][j] = best;
      split_[i][j] = at;
    }
  }
  return best_[0][ring - 1];
}

bool Swapper::list_triangles(int i, int j) {
  if (j - i < 2) return true;
  const int k = split_[i][j];
  const VertId p = shell_.ring[i], r = shell_.ring[k], s = shell_.ring[j];
  const double with_b = cavity_->judge(p, r, s, shell_.b), with_a = cavity_->judge(p, s, r, shell_.a);
  if (!(with_b > bound_) || !(with_a > bound_)) return false;
  triangles_.push_back({i, k, j, with_b, with_a});
  return list_triangles(i, k) && list_triangles(k, j);
}

void Swapper::swap_with_walls(int ring) {
  const std::int32_t ref = part_->mesh.tet_ref[shell_.tet[0]];
  for (const RingTriangle& t : triangles_) {
    const VertId p = shell_.ring[t.i], r = shell_.ring[t.k], s = shell_.ring[t.j];
    cavity_->accept(p, r, s, shell_.b, ref, t.with_b);
    cavity_->accept(p, s, r, shell_.a, ref, t.with_a);
  }
  const VertId r0 = shell_.ring[0], r1 = shell_.ring[ring - 1];
  cavity_->wall(r0, r1, shell_.a, shell_.tag[0]);
  cavity_->wall(r0, r1, shell_.b, shell_.tag[0]);
  cavity_->commit();
}

bool Swapper::gather(TetId t, VertId a, VertId b, int max_ring) {
  const TetMesh& m = part_->mesh;
  if (m.has(a, kFrozen) && m.has(b, kFrozen)) return false;
  if (!gather_shell(m, t, a, b, shell_, max_ring) || shell_.on_interface) return false;
  const int ring = shell_.ring_size();
  if (ring > max_ring || ring < 3) return false;
  const int tagged = shell_.tagged_faces();
  if (shell_.closed ? tagged != 0 : tagged != 2) return false;
  return shell_.closed || surface_swap_allowed();
}

double Swapper::worst_of_shell() const noexcept {
  float worst = 1;
  for (int i = 0; i < shell_.n; ++i) worst = std::min(worst, part_->q3[shell_.tet[i]]);
  return worst;
}

bool Swapper::make() {
  const int ring = shell_.ring_size();
  return best_triangulation(ring) > bound_ && make_triangles();
}

bool Swapper::make_triangles() {
  const int ring = shell_.ring_size();
  triangles_.clear();
  if (!list_triangles(0, ring - 1)) return false;
  cavity_->clear();
  for (int i = 0; i < shell_.n; ++i) cavity_->add(shell_.tet[i]);
  if (shell_.closed) {
    cavity_->commit_ring(shell_, triangles_);
  } else {
    swap_with_walls(ring);
  }
  ++part_->counts.swap;
  return true;
}

bool Swapper::edge(TetId t, VertId a, VertId b, int max_ring, double gain) {
  if (!gather(t, a, b, max_ring)) return false;
  bound_ = std::max(gain * worst_of_shell(), 1e-15);
  return make();
}

bool Swapper::edge_to_relax(TetId t, VertId a, VertId b, double floor_q3) {
  if (!gather(t, a, b, kMaxRing)) return false;
  bound_ = std::max(0.99 * std::min(worst_of_shell(), floor_q3), 1e-15);
  const int made = shell_.ring_size() - (shell_.closed ? 3 : 2);
  max_strain_ = 0.95 * part_->strain(a, b) / std::max(made, 1);
  const bool allowed = shell_.closed || may_connect(0, shell_.n);
  const bool done = allowed && make();
  max_strain_ = kAnyStrain;
  return done;
}

bool Swapper::edge_to_reduce_sum(TetId t, VertId a, VertId b, double floor_q3) {
  constexpr double kGain = 0.995;
  if (!gather(t, a, b, kMaxRing)) return false;
  bound_ = std::max(0.999 * std::min(worst_of_shell(), floor_q3), 1e-15);
  double sum = 0;
  for (int i = 0; i < shell_.n; ++i) sum += inverse_sixth_power(static_cast<double>(part_->q3[shell_.tet[i]]));
  return lightest_triangulation(shell_.ring_size()) < kGain * sum && make_triangles();
}

bool Swapper::any_edge(TetId t, int max_ring, bool remember) {
  const auto v = part_->mesh.tet2vert[t];
  const unsigned skip = (remember ? part_->refused[t] : 0U) | (max_ring <= 4 ? large_rings(part_->mesh, t) : 0U);
  for (std::size_t e = 0; e < 6; ++e) {
    if ((skip & (1U << e)) != 0) continue;
    if (edge(t, v[kEdgeVerts[e][0]], v[kEdgeVerts[e][1]], max_ring)) return true;
    if (remember) mark_refused(*part_, shell_);
  }
  return false;
}

bool Swapper::any(TetId t) {
  if (any_edge(t, kMaxRing, false)) return true;
  for (std::size_t f = 0; f < 4; ++f) {
    if (face(make_face(t, f))) return true;
  }
  return false;
}

bool Swapper::face(FaceId f, double gain) {
  const TetMesh& m = part_->mesh;
  const TetId t = face_tet(f);
  const FaceId g = m.tet2face[t][face_side(f)];
  if (g == kNoFace || m.face_tag[t][face_side(f)] != 0) return false;
  const VertId d = m.tet2vert[t][face_side(f)], e = m.apex(g);
  cavity_->clear();
  cavity_->add(t);
  cavity_->add(face_tet(g));
  const double bound = std::max(gain * cavity_->old_min_q3(), 1e-15);
  const auto k = m.verts(f);  // outward from t: (d, k0, k1, k2) is positive, e is on the other side
  const std::int32_t ref = m.tet_ref[t];
  for (std::size_t i = 0; i < 3; ++i) {
    if (!cavity_->propose(d, k[i], k[(i + 1) % 3], e, ref, bound)) return false;
  }
  cavity_->commit();
  ++part_->counts.swap;
  return true;
}

}  // namespace skein
