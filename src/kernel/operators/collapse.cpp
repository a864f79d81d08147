// Removal of a vertex: a neighbour is reinserted into its ball.
#include "kernel/operators/collapse.hpp"

#include <algorithm>
#include <type_traits>

namespace skein {
namespace {
constexpr std::size_t kMaxBall = 200;  ///< tetrahedra; no mesh worth keeping has more at a vertex that goes
}

bool Collapser::may_leave(VertId v, VertId u) const noexcept {
  const TetMesh& m = part_->mesh;
  if (m.has(v, kFrozen) || m.has(v, kStays)) return false;
  if (m.has(v, kSurface | kRidge) && !part_->options.may_change_surface()) return false;
  if (m.has(v, kRidge)) return m.has(u, kRidge | kCorner) && m.features.find(v, u) != nullptr;
  if (m.has(v, kSurface)) return m.has(u, kSurface);
  return true;
}

void Collapser::collect_facets(VertId v) {
  const TetMesh& m = part_->mesh;
  facets_.clear();
  for (const TetId t : cavity_->old_tets()) {
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceTag tag = m.face_tag[t][f];
      if (tag == 0 || m.tet2vert[t][f] == v) continue;
      auto k = m.verts(make_face(t, f));
      while (k[0] != v) std::rotate(k.begin(), k.begin() + 1, k.end());
      // An internal face is met from both sides; keep one.
      const FaceId nb = m.tet2face[t][f];
      if (nb != kNoFace && num(face_tet(nb)) < num(t)) continue;
      facets_.push_back({k[1], k[2], tag});
    }
  }
}

void Collapser::list_feature_ends(VertId v) {
  const TetMesh& m = part_->mesh;
  feature_ends_.clear();
  for (const TetId t : cavity_->old_tets()) {
    for (const VertId w : m.tet2vert[t]) {
      if (w == v || !m.has(w, kRidge | kCorner) || m.features.find(v, w) == nullptr) continue;
      if (std::find(feature_ends_.begin(), feature_ends_.end(), w) == feature_ends_.end()) feature_ends_.push_back(w);
    }
  }
}

bool Collapser::features_allow(VertId v, VertId u) const {
  const TetMesh& m = part_->mesh;
  return std::all_of(feature_ends_.begin(), feature_ends_.end(), [&](VertId w) {
    // A loop of three feature edges would become one edge.
    return w == u || (m.features.find(u, w) == nullptr && part_->geometry->allows_ridge_collapse(m, v, u, w));
  });
}

bool Collapser::surface_allows(VertId v, VertId u) {
  int at_edge = 0;
  for (const Facet& f : facets_) {
    if ((f.tag & kRequiredFace) != 0) return false;
    at_edge += f.x == u || f.y == u ? 1 : 0;
  }
  if (at_edge == 0) return false;  // (v, u) is no edge of the surface
  return part_->geometry->allows_collapse(part_->mesh, v, u, facets_) && links_meet_in_facets(v, u);
}

bool Collapser::links_meet_in_facets(VertId v, VertId u) {
  const TetMesh& m = part_->mesh;
  const std::uint32_t stamp = ++part_->vert_stamp;
  for (const Facet& f : facets_) {
    if (f.x != u) part_->vert_mark[f.x] = stamp;
    if (f.y != u) part_->vert_mark[f.y] = stamp;
  }
  for (const Facet& f : facets_) {
    if (f.x == u) part_->vert_mark[f.y] = 0;
    if (f.y == u) part_->vert_mark[f.x] = 0;
  }
  const std::uint32_t keep = part_->tet_stamp;
  ball_u_.clear();  // all of it, also where bodies touch
  bool ok = gather_ball(*part_, u, ball_u_);
  for (std::size_t i = 0; i < ball_u_.size() && ok; ++i) {
    const TetId t = ball_u_[i];
    for (std::size_t f = 0; f < 4 && ok; ++f) {
      if (m.face_tag[t][f] == 0 || m.tet2vert[t][f] == u) continue;
      auto k = m.verts(make_face(t, f));
      while (k[0] != u) std::rotate(k.begin(), k.begin() + 1, k.end());
      if (k[1] == v || k[2] == v) continue;
      ok = part_->vert_mark[k[1]] != stamp && part_->vert_mark[k[2]] != stamp && !has_facet(k[1], k[2]);
    }
  }
  // Restore the cavity's marks that gather_ball has overwritten.
  for (const TetId t : cavity_->old_tets()) part_->tet_mark[t] = keep;
  return ok;
}

bool Collapser::has_facet(VertId x, VertId y) const noexcept {
  return std::any_of(facets_.begin(), facets_.end(),
                     [&](const Facet& f) { return (f.x == x && f.y == y) || (f.x == y && f.y == x); });
}

template <class Fits>
bool Collapser::add_fans(VertId v, VertId u, Fits&& fits) {
  const TetMesh& m = part_->mesh;
  for (const TetId t : part_->contacts.at(v)) {
    if (!ContactFans::is_at(m, t, v) || cavity_->contains(t)) continue;
    for (const VertId w : m.tet2vert[t]) {
      if (w != v && w != u && !fits(w)) return false;
    }
    cavity_->add(t);
  }
  return true;
}

bool Collapser::gather_within(VertId v, VertId u, TetId at, double max_length) {
  // The lengths are looked at on the way, since most attempts end at an edge that would get too long: what is a
  // neighbour of u already may be as far as it is.
  Part& p = *part_;
  const TetMesh& m = p.mesh;
  bool ring_known = false;
  const auto is_neighbour = [&](VertId w) {
    if (!ring_known) ring_known = gather_shell(m, at, v, u, shell_);
    const auto end = shell_.ring.begin() + shell_.n + 1;
    return ring_known && std::find(shell_.ring.begin(), end, w) != end;
  };
  const auto fits = [&](VertId w) { return w == u || !p.is_longer(u, w, max_length) || is_neighbour(w); };
  cavity_->add(at);
  if (!part_->contacts.empty() && !add_fans(v, u, fits)) return false;
  return walk_ball(m, v, cavity_->old_tets(), 0, kMaxBall, [&](FaceId f) {
    const TetId nb = face_tet(f);
    if (cavity_->contains(nb)) return true;
    if (!fits(m.tet2vert[nb][face_side(f)])) return false;
    cavity_->add(nb);
    return true;
  });
}

bool Collapser::facets_can_move(VertId v, VertId u) const noexcept {
  const TetMesh& m = part_->mesh;
  for (const TetId t : cavity_->old_tets()) {
    const auto& tv = m.tet2vert[t];
    if (!has_vertex(tv, u)) continue;
    // The tetrahedron vanishes, and its facet at v without u comes to lie on its face opposite v.
    const auto at_u = local_index(tv, u), at_v = local_index(tv, v);
    const FaceTag facet = m.face_tag[t][at_u], onto = m.face_tag[t][at_v];
    if (facet == 0) continue;
    if (!is_hull(facet) || onto != 0 || m.tet2face[t][at_v] == kNoFace) return false;
  }
  return true;
}

bool Collapser::cone(VertId v, VertId u, double floor_q3) {
  const TetMesh& m = part_->mesh;
  cavity_->clear_new();
  for (const TetId t : cavity_->old_tets()) {
    const auto& tv = m.tet2vert[t];
    if (has_vertex(tv, u)) continue;
    // The only outer face that is coned is the one opposite v; faces at v are inner ones or walls.
    const auto k = m.verts(make_face(t, local_index(tv, v)));
    if (!cavity_->propose(u, k[0], k[1], k[2], m.tet_ref[t], floor_q3)) return false;
  }
  return true;
}

void Collapser::move_features(VertId v, VertId u) {
  TetMesh& m = part_->mesh;
  for (const VertId w : feature_ends_) {
    const FeatureEdge old = *m.features.find(v, w);
    m.features.erase(v, w);
    if (w != u) m.features.insert({u, w, old.ref, old.edge_class});
  }
}

void Collapser::commit(VertId v, VertId u) {
  if (part_->mesh.has(v, kSurface)) {
    for (const Facet& f : facets_) {
      if (f.x != u && f.y != u) cavity_->wall(u, f.x, f.y, f.tag);
    }
  }
  if (part_->mesh.has(v, kRidge)) move_features(v, u);
  cavity_->commit();
  drop_vertex(*part_, v);
  ++part_->counts.collapse;
}

bool Collapser::lowers_strain(VertId v, VertId u, TetId at, double strain_share) {
  Part& p = *part_;
  if (!gather_shell(p.mesh, at, v, u, shell_)) return false;
  const std::uint32_t stamp = ++p.vert_stamp;
  p.vert_mark[v] = p.vert_mark[u] = stamp;
  double was = p.strain(v, u), is = 0;
  const auto goes = [&](VertId w) {
    if (p.vert_mark[w] == stamp) return false;
    p.vert_mark[w] = stamp;
    was += p.strain(v, w);
    return true;
  };
  for (int i = 0; i < shell_.ring_size(); ++i) goes(shell_.ring[i]);
  for (const TetId t : cavity_->old_tets()) {
    for (const VertId w : p.mesh.tet2vert[t]) {
      if (goes(w)) is += p.strain(u, w);
    }
  }
  return is < strain_share * was;
}

template <class Objective>
bool Collapser::collapse(VertId v, VertId u, TetId at, double max_length, const Objective& objective) {
  if (!may_leave(v, u)) return false;
  const TetMesh& m = part_->mesh;
  cavity_->clear();
  if (!gather_within(v, u, at, max_length)) return false;
  if constexpr (std::is_same_v<Objective, LowerStrain>) {
    if (!lowers_strain(v, u, at, objective.strain_share)) return false;
  }
  if (m.has(v, kSurface)) {
    if (!facets_can_move(v, u)) return false;
    collect_facets(v);
  }
  if (!cone(v, u, objective.bound(cavity_->old_min_q3()))) return false;
  if constexpr (std::is_same_v<Objective, LowerSum>) {
    if (!(cavity_->new_sum() < objective.sum_share * cavity_->old_sum())) return false;
  }
  if (m.has(v, kSurface) && !surface_allows(v, u)) return false;
  if (m.has(v, kRidge)) {
    list_feature_ends(v);
    if (!features_allow(v, u)) return false;
  }
  commit(v, u);
  return true;
}
template bool Collapser::collapse(VertId, VertId, TetId, double, const KeepFloor&);
template bool Collapser::collapse(VertId, VertId, TetId, double, const RaiseWorst&);
template bool Collapser::collapse(VertId, VertId, TetId, double, const LowerStrain&);
template bool Collapser::collapse(VertId, VertId, TetId, double, const LowerSum&);

}  // namespace skein
