// Insertion of points as Delaunay cavities in the metric.
#include "kernel/insert.hpp"

namespace skein {
namespace {

constexpr std::size_t kMaxCavity = 96;
constexpr int kShrinkTurns = 4;

/// Positive when the origin lies inside the circumsphere, in the metric m, of the positively oriented tetrahedron with
/// vertices a, b, c, d relative to it.
double in_sphere(const SymTensor& m, Vec3 a, Vec3 b, Vec3 c, Vec3 d) noexcept {
  const Vec3 cd = cross(c, d), ab = cross(a, b);
  const double bcd = dot(b, cd), acd = dot(a, cd), abd = dot(ab, d), abc = dot(ab, c);
  return quad(m, a) * bcd - quad(m, b) * acd + quad(m, c) * abd - quad(m, d) * abc;
}

}  // namespace

bool Inserter::is_split_face(FaceId f) const noexcept {
  if (!on_edge_ || part_->mesh.face_tag[face_tet(f)][static_cast<std::size_t>(face_side(f))] == 0) return false;
  const auto& tv = part_->mesh.tet2vert[face_tet(f)];
  const VertId apex = tv[static_cast<std::size_t>(face_side(f))];
  return apex != shell_.a && apex != shell_.b && has_vertex(tv, shell_.a) && has_vertex(tv, shell_.b);
}

bool Inserter::is_inner(FaceId f) const noexcept {
  // The cavity may grow round a tagged face, coming to it from both sides. Such a face stays: it counts as outer for
  // both, and the side that cannot see the new point falls away.
  const FaceId nb = part_->mesh.tet2face[face_tet(f)][static_cast<std::size_t>(face_side(f))];
  return nb != kNoFace && cavity_->contains(face_tet(nb)) &&
         part_->mesh.face_tag[face_tet(f)][static_cast<std::size_t>(face_side(f))] == 0;
}

void Inserter::grow(VertId p) {
  const TetMesh& m = part_->mesh;
  const Vec3 xp = part_->x(p);
  const SymTensor& metric = part_->metric.at[p].m;
  auto& old = cavity_->old_tets();
  for (std::size_t i = 0; i < old.size() && old.size() < kMaxCavity; ++i) {
    const TetId t = old[i];
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceId nf = m.tet2face[t][f];
      if (nf == kNoFace || m.face_tag[t][f] != 0) continue;
      const TetId nb = face_tet(nf);
      if (cavity_->contains(nb)) continue;
      const auto& v = m.tet2vert[nb];
      const Vec3 a = part_->x(v[0]) - xp, b = part_->x(v[1]) - xp, c = part_->x(v[2]) - xp, d = part_->x(v[3]) - xp;
      if (in_sphere(metric, a, b, c, d) > 0) cavity_->add(nb);
    }
  }
}

bool Inserter::shrink_and_cone(VertId p, std::size_t seeds, double floor_q3) {
  const TetMesh& m = part_->mesh;
  auto& old = cavity_->old_tets();
  // A cavity that is still not star-shaped after a few turns is a bad one, and each turn judges all of it again.
  for (int turn = 0; turn < kShrinkTurns; ++turn) {
    cavity_->clear_new();
    bool shrunk = false;
    for (std::size_t i = 0; i < old.size(); ++i) {
      const TetId t = old[i];
      for (int f = 0; f < 4; ++f) {
        const FaceId face = make_face(t, f);
        if (is_inner(face) || is_split_face(face)) continue;
        const auto v = face_verts(m, face);
        if (cavity_->propose(p, v[0], v[1], v[2], m.tet_ref[t], floor_q3)) continue;
        if (i < seeds) return false;
        cavity_->remove_at(i);
        --i;
        shrunk = true;
        break;
      }
    }
    if (!shrunk) return true;
  }
  return false;
}

bool Inserter::too_close(VertId p, double min_length) {
  const std::uint32_t stamp = ++part_->vert_stamp;
  for (const TetId t : cavity_->old_tets()) {
    for (const VertId v : part_->mesh.tet2vert[t]) {
      if (part_->vert_mark[v] == stamp) continue;
      part_->vert_mark[v] = stamp;
      if (part_->length(p, v) < min_length) return true;
    }
  }
  return false;
}

bool Inserter::neighbours_too_close(VertId p, double min_length) {
  const TetMesh& m = part_->mesh;
  for (const TetId t : cavity_->old_tets()) {
    for (const FaceId nb : m.tet2face[t]) {
      if (nb == kNoFace || cavity_->contains(face_tet(nb))) continue;
      if (part_->length(p, m.tet2vert[face_tet(nb)][static_cast<std::size_t>(face_side(nb))]) < min_length) return true;
    }
  }
  return false;
}

bool Inserter::loses_vertex(VertId) {
  // Vertices on an outer face survive; walls' vertices do, too, as the shell's ring.
  const TetMesh& m = part_->mesh;
  const std::uint32_t kept = ++part_->vert_stamp;
  const auto& old = cavity_->old_tets();
  for (const TetId t : old) {
    for (int f = 0; f < 4; ++f) {
      if (is_inner(make_face(t, f)) || is_split_face(make_face(t, f))) continue;
      for (const VertId v : face_verts(m, make_face(t, f))) part_->vert_mark[v] = kept;
    }
  }
  for (const TetId t : old) {
    for (const VertId v : m.tet2vert[t]) {
      if (part_->vert_mark[v] != kept) return true;
    }
  }
  return false;
}

InsertResult Inserter::insert(VertId p, std::size_t seeds, double min_length) {
  const double seed_min = cavity_->old_min_q3();
  if (too_close(p, min_length)) return InsertResult::kTooClose;
  grow(p);
  constexpr double kGood = 0.2 * 0.2 * 0.2;
  const double floor_q3 = std::max(1e-15, std::min(kGood, 0.125 * seed_min));
  if (!shrink_and_cone(p, seeds, floor_q3) || loses_vertex(p)) {
    auto& old = cavity_->old_tets();
    if (old.size() == seeds) return InsertResult::kRefused;
    while (old.size() > seeds) cavity_->remove_at(old.size() - 1);
    if (!shrink_and_cone(p, seeds, floor_q3) || loses_vertex(p)) return InsertResult::kRefused;
  }
  if (too_close(p, min_length) || (seed_min < kGood && neighbours_too_close(p, min_length)))
    return InsertResult::kTooClose;
  return InsertResult::kDone;
}

InsertResult Inserter::on_edge(TetId t, VertId a, VertId b, double s) {
  Part& part = *part_;
  TetMesh& m = part.mesh;
  if (!gather_shell(m, t, a, b, shell_)) return InsertResult::kRefused;
  // Where the surface is not a manifold, a fan between hull faces may have its other fans in another part.
  const bool shared = !shell_.closed && m.has(a, kFrozen) && m.has(b, kFrozen);
  if (shell_.on_interface || shared) return InsertResult::kRefused;
  std::uint8_t flags = 0;
  bool kept = false;
  for (int i = 0; i < shell_.ring_size(); ++i) {
    const FaceTag tag = shell_.tag[static_cast<std::size_t>(i)];
    if (tag != 0) flags |= kSurface;
    kept = kept || (tag & kRequiredFace) != 0;
  }
  if (kept || (flags != 0 && !part.options.surface)) return InsertResult::kRefused;
  const FeatureEdge* feature = nullptr;
  if (m.has(a, kRidge) && m.has(b, kRidge)) feature = m.features.find(a, b);
  if (feature != nullptr) flags |= kRidge;

  on_edge_ = true;
  cavity_->clear();
  for (int i = 0; i < shell_.n; ++i) cavity_->add(shell_.tet[static_cast<std::size_t>(i)]);
  const Vec3 x = part.x(a) + s * (part.x(b) - part.x(a));
  const SymTensor log_m = (1 - s) * part.metric.log_at[a] + s * part.metric.log_at[b];
  const VertId p = new_vertex(part, x, log_m, flags);
  const InsertResult result = insert(p, static_cast<std::size_t>(shell_.n), part.options.length_min_new);
  if (result != InsertResult::kDone) {
    drop_vertex(part, p);
    return result;
  }
  for (int i = 0; i < shell_.ring_size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (shell_.tag[k] == 0) continue;
    cavity_->wall(a, p, shell_.ring[k], shell_.tag[k]);
    cavity_->wall(p, b, shell_.ring[k], shell_.tag[k]);
  }
  if (feature != nullptr) {
    const FeatureEdge e = *feature;
    m.features.erase(a, b);
    m.features.insert(a, p, e.ref, e.ridge);
    m.features.insert(p, b, e.ref, e.ridge);
    m.vert_ref[p] = e.ref;
  }
  cavity_->commit();
  ++part.counts.insert;
  return result;
}

InsertResult Inserter::inside(TetId t, const std::array<double, 4>& weight, double exclusion) {
  Part& part = *part_;
  const auto v = part.mesh.tet2vert[t];
  Vec3 x;
  SymTensor log_m;
  for (std::size_t i = 0; i < 4; ++i) {
    x += weight[i] * part.x(v[i]);
    log_m = log_m + weight[i] * part.metric.log_at[v[i]];
  }
  on_edge_ = false;
  cavity_->clear();
  cavity_->add(t);
  const VertId p = new_vertex(part, x, log_m, 0);
  const InsertResult result = insert(p, 1, exclusion);
  if (result != InsertResult::kDone) {
    drop_vertex(part, p);
    return result;
  }
  cavity_->commit();
  ++part.counts.insert;
  return result;
}

}  // namespace skein
