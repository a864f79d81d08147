// Edge swapping over the skew polygon (dynamic programming) and face swapping.
#include "kernel/operators/swap.hpp"

#include <algorithm>
#include <type_traits>

namespace skein {
namespace {
/// Q^3 that counts as flat: no swap makes elements that are worse.
constexpr double kFlat = 1e-15;

/// Triangulations by their worst element.
struct WorstElement {
  static constexpr double kEmpty = 1, kNone = -1;  ///< of no triangle; worse than any
  static double join(double a, double b) noexcept { return std::min(a, b); }
  static bool better(double a, double b) noexcept { return a > b; }
  static bool hopeless(double score, double bound) noexcept { return score <= bound; }
  /// Of one triangle, whose elements have Q^3 `top` and under(); `bound`: what both must exceed.
  template <class Under>
  static double score(double top, Under&& under, double bound) noexcept {
    return top <= bound ? top : std::min(top, under());
  }
};

/// Triangulations by the sum of Q^-6; those with an element that is not above the bound are no choice.
struct LeastSum {
  static constexpr double kEmpty = 0, kNone = 1e300;
  static double join(double a, double b) noexcept { return a + b; }
  static bool better(double a, double b) noexcept { return a < b; }
  static bool hopeless(double, double) noexcept { return false; }
  template <class Under>
  static double score(double top, Under&& under, double bound) noexcept {
    if (top <= bound) return kNone;
    const double other = under();
    return other <= bound ? kNone : inverse_sixth_power(top) + inverse_sixth_power(other);
  }
};
}  // namespace

bool Swapper::surface_swap_allowed() {
  const TetMesh& m = part_->mesh;
  const FaceTag first = shell_.tag[0], last = shell_.tag[shell_.n];
  if (shell_.n < 2 || first != last || (first & kRequiredFace) != 0 || !part_->options.may_change_surface())
    return false;
  const VertId a = shell_.a, b = shell_.b;
  if (m.feature(a, b) != nullptr) return false;
  // ring[0] .. ring[n] turns counter-clockwise seen from b, with the domain between; outside of the first face is a, b
  // reversed.
  return part_->geometry->allows_swap(m, a, b, shell_.ring[0], shell_.ring[shell_.n]);
}

bool Swapper::may_connect(int i, int j) const noexcept {
  if (j - i < 2 || (shell_.closed && j - i == shell_.n - 1)) return true;
  return part_->strain(shell_.ring[i], shell_.ring[j]) < max_strain_;
}

template <class Score, class MayUse>
double Swapper::best_triangulation(int ring, MayUse&& may_use) {
  const auto triangle = [&](int i, int j, int k) {
    const VertId p = shell_.ring[i], r = shell_.ring[j], s = shell_.ring[k];
    const double top = part_->quality_cubed(p, r, s, shell_.b);
    return Score::score(
        top, [&] { return part_->quality_cubed(p, s, r, shell_.a); }, bound_);
  };
  for (int i = 0; i + 1 < ring; ++i) best_[i][i + 1] = Score::kEmpty;
  for (int len = 2; len < ring; ++len) {
    for (int i = 0; i + len < ring; ++i) {
      const int j = i + len;
      double best = Score::kNone;
      int at = i + 1;
      for (int k = i + 1; k < j; ++k) {
        const double sides = Score::join(best_[i][k], best_[k][j]);
        if (!Score::better(sides, best) || Score::hopeless(sides, bound_) || !may_use(i, k, j)) continue;
        const double w = Score::join(sides, triangle(i, k, j));
        if (Score::better(w, best)) best = w, at = k;
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

double Swapper::sum_of_shell() const noexcept {
  double sum = 0;
  for (int i = 0; i < shell_.n; ++i) sum += inverse_sixth_power(static_cast<double>(part_->q3[shell_.tet[i]]));
  return sum;
}

bool Swapper::are_joined_elsewhere(VertId a, VertId b) {
  ball_.clear();
  if (!gather_ball(*part_, a, ball_)) return true;
  return std::any_of(ball_.begin(), ball_.end(), [&](TetId t) {
    const auto end = shell_.tet.begin() + shell_.n;
    return has_vertex(part_->mesh.tet2vert[t], b) && std::find(shell_.tet.begin(), end, t) == end;
  });
}

bool Swapper::make_triangles() {
  const TetMesh& m = part_->mesh;
  const int ring = shell_.ring_size();
  triangles_.clear();
  if (!list_triangles(0, ring - 1)) return false;
  if (shell_.closed && m.has(shell_.a, kThin) && m.feature(shell_.a, shell_.b) != nullptr) return false;
  if (!shell_.closed && are_joined_elsewhere(shell_.ring[0], shell_.ring[ring - 1])) return false;
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

template <class Objective>
bool Swapper::edge(TetId t, VertId a, VertId b, const Objective& objective, int max_ring) {
  if (!gather(t, a, b, max_ring)) return false;
  const int ring = shell_.ring_size();
  [[maybe_unused]] const auto any = [](int, int, int) { return true; };
  bound_ = std::max(objective.bound(worst_of_shell()), kFlat);
  if constexpr (std::is_same_v<Objective, LowerSum>) {
    const double old_sum = sum_of_shell();
    if (!(best_triangulation<LeastSum>(ring, any) < objective.sum_share * old_sum)) return false;
  } else if constexpr (std::is_same_v<Objective, LowerStrain>) {
    const int made = ring - (shell_.closed ? 3 : 2);
    max_strain_ = objective.strain_share * part_->strain(a, b) / std::max(made, 1);
    if (!shell_.closed && !may_connect(0, shell_.n)) return false;
    const auto little_strain = [&](int i, int k, int j) { return may_connect(i, k) && may_connect(k, j); };
    if (!(best_triangulation<WorstElement>(ring, little_strain) > bound_)) return false;
  } else {
    if (!(best_triangulation<WorstElement>(ring, any) > bound_)) return false;
  }
  return make_triangles();
}
template bool Swapper::edge(TetId, VertId, VertId, const RaiseWorst&, int);
template bool Swapper::edge(TetId, VertId, VertId, const LowerStrain&, int);
template bool Swapper::edge(TetId, VertId, VertId, const LowerSum&, int);

bool Swapper::any_edge(TetId t, const RaiseWorst& objective, int max_ring, Try which) {
  const unsigned refused = which == Try::kNotRefused ? part_->refused[t] : 0U;
  const unsigned skip = refused | (max_ring <= 4 ? large_rings(part_->mesh, t) : 0U);
  for (std::size_t e = 0; e < 6; ++e) {
    if ((skip & (1U << e)) != 0) continue;
    const auto [a, b] = part_->mesh.edge_verts(t, e);
    if (edge(t, a, b, objective, max_ring)) return true;
    if (which == Try::kNotRefused) mark_refused(*part_, shell_);
  }
  return false;
}

bool Swapper::any(TetId t, const RaiseWorst& objective) {
  if (any_edge(t, objective, kMaxRing, Try::kAll)) return true;
  for (std::size_t f = 0; f < 4; ++f) {
    if (face(make_face(t, f), objective)) return true;
  }
  return false;
}

bool Swapper::face(FaceId f, const RaiseWorst& objective) {
  const TetMesh& m = part_->mesh;
  const FaceId g = m.neighbour(f);
  if (g == kNoFace || m.tag(f) != 0) return false;
  const TetId t = face_tet(f);
  if (part_->must_stay(t) || part_->must_stay(face_tet(g))) return false;
  const VertId d = m.apex(f), e = m.apex(g);
  cavity_->clear();
  cavity_->add(t);
  cavity_->add(face_tet(g));
  const double bound = std::max(objective.bound(cavity_->old_min_q3()), kFlat);
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
