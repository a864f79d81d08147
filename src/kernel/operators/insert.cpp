// Insertion of points as Delaunay cavities in the metric.
#include "kernel/operators/insert.hpp"

#include <algorithm>

namespace skein {
namespace {

/// Edge bits of a tetrahedron -> those of its face's edges in a new tetrahedron (p, v0, v1, v2) on that face.
constexpr auto kBaseEdges = [] {
  std::array<std::array<std::uint8_t, 64>, 4> table{};
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& k = kFaceVerts[f];
    const auto edge = [&](int i, int j) { return kEdgeOf[k[i]][k[j]]; };
    for (unsigned bits = 0; bits < 64; ++bits) {
      table[f][bits] = static_cast<std::uint8_t>((bits >> edge(0, 1) & 1U) << 3 | (bits >> edge(0, 2) & 1U) << 4 |
                                                 (bits >> edge(1, 2) & 1U) << 5);
    }
  }
  return table;
}();
/// Asks for what the test of t will read, and what comes after it if t is inside. Inlined, since a function that only
/// asks for data counts as one without effect.
[[gnu::always_inline]] inline void fetch(const Part& p, TetId t) noexcept {
  for (const VertId v : p.mesh.tet2vert[t]) {
    __builtin_prefetch(&p.mesh.coords[v]);
    __builtin_prefetch(&p.mesh.metric[v]);
  }
  __builtin_prefetch(&p.mesh.tet2face[t]);
  __builtin_prefetch(&p.mesh.face_tag[t]);
}

EdgeBits base_edges(EdgeBits old, std::size_t side) noexcept {
  return {kBaseEdges[side][old.may_be_long], kBaseEdges[side][old.may_be_short]};
}

}  // namespace

bool Inserter::is_split_face(FaceId f) const noexcept {
  if (!on_edge_) return false;
  const auto& tv = part_->mesh.tet2vert[face_tet(f)];
  const VertId apex = tv[face_side(f)];
  return apex != shell_.a && apex != shell_.b && has_vertex(tv, shell_.a) && has_vertex(tv, shell_.b);
}

void Inserter::grow(VertId p) {
  // Layer by layer, and within a layer first all neighbours, then all tests, without branches on what is found: that is
  // as good as random, and a wrong guess costs more than a test.
  const TetMesh& m = part_->mesh;
  auto& old = cavity_->old_tets();
  const auto largest = static_cast<std::size_t>(part_->options.method.insert.largest_cavity);
  for (std::size_t from = 0; from < old.size() && old.size() < largest;) {
    if (around_.size() < 4 * old.size()) around_.resize(4 * old.size());
    std::size_t n = 0;
    for (; from < old.size(); ++from) {
      const TetId t = old[from];
      for (std::size_t f = 0; f < 4; ++f) {
        const FaceId nf = m.tet2face[t][f];
        const bool shut = nf == kNoFace || m.face_tag[t][f] != 0;
        const TetId nb = shut ? t : face_tet(nf);
        __builtin_prefetch(&m.tet2vert[nb]);
        around_[n] = nb;
        n += cavity_->meet(nb) ? 1 : 0;
      }
    }
    for (std::size_t i = 0; i < n; ++i) fetch(*part_, around_[i]);
    spheres_.clear();
    for (std::size_t i = 0; i < n; ++i) spheres_.add(*part_, m.tet2vert[around_[i]]);
    spheres_.test(part_->x(p), part_->mesh.metric[p].m);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < n; ++i) {
      around_[inside] = around_[i];
      inside += spheres_.contain(i) ? 1 : 0;
    }
    if (part_->has_required_tets) {
      const auto end = std::remove_if(around_.begin(), around_.begin() + static_cast<std::ptrdiff_t>(inside),
                                      [&](TetId t) { return part_->must_stay(t); });
      inside = static_cast<std::size_t>(end - around_.begin());
    }
    for (std::size_t i = 0; i < inside; ++i) cavity_->add(around_[i]);
  }
}

void Inserter::collect_border() {
  // The cavity may grow round a tagged face, coming to it from both sides. Such a face stays: it counts as outer for
  // both, and the side that cannot see the new point falls away.
  const TetMesh& m = part_->mesh;
  const auto& old = cavity_->old_tets();
  if (outer_.size() < 4 * old.size()) outer_.resize(4 * old.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < old.size(); ++i) {
    const TetId t = old[i];
    for (std::size_t f = 0; f < 4; ++f) {
      const FaceId nf = m.tet2face[t][f];
      const bool shut = nf == kNoFace || m.face_tag[t][f] != 0;
      outer_[n] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(f)};
      n += shut || !cavity_->contains(face_tet(nf)) ? 1 : 0;
    }
  }
  border_.clear();
  cone_.clear();
  walled_ = false;
  for (std::size_t k = 0; k < n; ++k) {
    const auto [i, s] = outer_[k];
    const TetId t = old[i];
    const FaceId face = make_face(t, s);
    const FaceTag tag = m.face_tag[t][s];
    if (tag != 0 && is_split_face(face)) {
      walled_ = true;
      continue;
    }
    const auto v = m.verts(face);
    border_.push_back({v, m.tet2face[t][s], i, m.tet_ref[t], tag, base_edges(part_->edges[t], s)});
    cone_.add(*part_, v[0], v[1], v[2]);
  }
}

bool Inserter::cone_is_good(VertId p, double floor_q3) {
  if (part_->quality_measure == QualityMeasure::kLargestMetric) return true;
  for (std::size_t i = 0; i < border_.size(); ++i) {
    const auto& v = border_[i].v;
    const double q3 = part_->quality_cubed(p, v[0], v[1], v[2]);
    if (!(q3 > floor_q3)) return false;
    cone_.set_q3(i, q3);
  }
  return true;
}

bool Inserter::is_pressed(std::size_t i) const noexcept {
  const BorderFace& f = border_[i];
  if (cone_.q3(i) > fixed_face_floor() || cone_.q3(i) >= static_cast<double>(part_->q3[cavity_->old_tets()[f.old]]))
    return false;
  const TetMesh& m = part_->mesh;
  if (f.tag != 0 && (!part_->options.may_change_surface() || (f.tag & kRequiredFace) != 0)) return true;
  return m.has(f.v[0], kFrozen) && m.has(f.v[1], kFrozen) && m.has(f.v[2], kFrozen);
}

bool Inserter::keeps_distance() const noexcept {
  for (std::size_t i = 0; i < border_.size(); ++i) {
    if (is_pressed(i)) return false;
  }
  return true;
}

bool Inserter::shrink_and_cone(VertId p, std::size_t seeds, double floor_q3) {
  auto& old = cavity_->old_tets();
  // A cavity that is still not star-shaped after a few turns is a bad one, and each turn judges all of it again.
  for (int turn = 0; turn < part_->options.method.insert.shrink_turns; ++turn) {
    collect_border();
    const double lowest = cone_.judge(part_->x(p), part_->mesh.metric[p]);
    if (lowest > floor_q3 && (lowest > fixed_face_floor() || keeps_distance())) return true;
    // What has a bad face goes; from the end on, since removing moves the last one into the gap.
    std::size_t last = old.size();
    for (std::size_t i = border_.size(); i-- > 0;) {
      if ((cone_.q3(i) > floor_q3 && !is_pressed(i)) || border_[i].old == last) continue;
      last = border_[i].old;
      if (last < seeds) return false;
      cavity_->remove_at(last);
    }
  }
  return false;
}

bool Inserter::too_close(VertId p, double min_length) {
  const auto& old = cavity_->old_tets();
  if (link_.size() < 4 * old.size()) link_.resize(4 * old.size());
  const std::uint32_t stamp = ++part_->vert_stamp;
  std::size_t n = 0;
  for (const TetId t : old) {
    for (const VertId v : part_->mesh.tet2vert[t]) {
      link_[n] = v;
      n += part_->vert_mark[v] != stamp ? 1 : 0;
      part_->vert_mark[v] = stamp;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (part_->is_shorter(p, link_[i], min_length)) return true;
  }
  return false;
}

bool Inserter::neighbours_too_close(VertId p, double min_length) {
  for (const BorderFace& f : border_) {
    if (f.behind == kNoFace) continue;
    const TetId nb = face_tet(f.behind);
    if (cavity_->contains(nb)) continue;
    const VertId v = part_->mesh.tet2vert[nb][face_side(f.behind)];
    if (part_->is_shorter(p, v, min_length)) return true;
  }
  return false;
}

bool Inserter::keeps_vertices() {
  // Vertices on a face of the border survive; those of walls do, too, as the shell's ring.
  std::size_t inside = 0;
  if (link_.size() < 3 * border_.size()) link_.resize(3 * border_.size());
  n_link_ = 0;
  const std::uint32_t stamp = ++part_->vert_stamp;
  for (const BorderFace& f : border_) {
    for (const VertId v : f.v) {
      link_[n_link_] = v;
      n_link_ += part_->vert_mark[v] != stamp ? 1 : 0;
      part_->vert_mark[v] = stamp;
    }
  }
  for (const TetId t : cavity_->old_tets()) {
    for (const VertId v : part_->mesh.tet2vert[t]) inside += part_->vert_mark[v] != stamp ? 1 : 0;
  }
  return inside == 0 && (!part_->has_thin || keeps_thin_edges());
}

bool Inserter::is_on_border(VertId a, VertId b) const noexcept {
  return std::any_of(border_.begin(), border_.end(), [&](const BorderFace& f) {
    return std::find(f.v.begin(), f.v.end(), a) != f.v.end() && std::find(f.v.begin(), f.v.end(), b) != f.v.end();
  });
}

bool Inserter::keeps_thin_edges() const {
  const TetMesh& m = part_->mesh;
  for (const TetId t : cavity_->old_tets()) {
    const auto& tv = m.tet2vert[t];
    if (std::none_of(tv.begin(), tv.end(), [&](VertId v) { return m.has(v, kThin); })) continue;
    for (const auto& e : kEdgeVerts) {
      const VertId a = tv[e[0]], b = tv[e[1]];
      if (!m.has(a, kThin) || m.feature(a, b) == nullptr) continue;
      const bool is_split = on_edge_ && (a == shell_.a || a == shell_.b) && (b == shell_.a || b == shell_.b);
      if (!is_split && !is_on_border(a, b)) return false;
    }
  }
  return true;
}

bool Inserter::link_too_close(VertId p, double min_length) {
  for (const VertId v : link()) {
    const std::uint8_t bits = part_->classify(p, v);
    const bool may_be = (bits & kMayBeShort) != 0 || min_length > part_->options.method.lengths.collapse_below;
    if (may_be && part_->is_shorter(p, v, min_length)) return true;
    part_->edge_class[v] = bits;
  }
  return false;
}

InsertResult Inserter::insert(VertId p, std::size_t seeds, double min_length) {
  const double seed_min = cavity_->old_min_q3();
  if (too_close(p, min_length)) return InsertResult::kTooClose;
  grow(p);
  const Method::Insert& o = part_->options.method.insert;
  const double good = cube(o.good_quality);
  double floor_q3 = std::max(1e-15, std::min(good, o.seed_share * seed_min));
  if (floor_ == Floor::kStrict) floor_q3 = std::max(floor_q3, std::min(cube(o.strict_floor), seed_min));
  if (!shrink_and_cone(p, seeds, floor_q3) || !keeps_vertices()) {
    auto& old = cavity_->old_tets();
    if (old.size() == seeds) return InsertResult::kRefused;
    while (old.size() > seeds) cavity_->remove_at(old.size() - 1);
    if (!shrink_and_cone(p, seeds, floor_q3) || !keeps_vertices()) return InsertResult::kRefused;
  }
  if (link_too_close(p, min_length) || (seed_min < good && neighbours_too_close(p, min_length)))
    return InsertResult::kTooClose;
  return cone_is_good(p, floor_q3) ? InsertResult::kDone : InsertResult::kRefused;
}

void Inserter::commit(VertId p) {
  if (!walled_ && n_link_ <= Cavity::kMaxLink) {
    cavity_->commit_cone(p, border_, cone_, link());
    return;
  }
  for (std::size_t i = 0; i < border_.size(); ++i) {
    const BorderFace& f = border_[i];
    cavity_->accept(p, f.v[0], f.v[1], f.v[2], f.ref, cone_.q3(i));
  }
  cavity_->commit();
}

std::optional<EdgeKind> Inserter::kind_of_edge() const noexcept {
  const Part& part = *part_;
  const TetMesh& m = part.mesh;
  // Where the surface is not a manifold, a fan between hull faces may have its other fans in another part.
  const bool shared = !shell_.closed && m.has(shell_.a, kFrozen) && m.has(shell_.b, kFrozen);
  if (shell_.on_interface || shared) return {};
  if (must_stay(shell_)) return {};
  const bool surface = shell_.tagged_faces() != 0;
  if (surface && !part.options.may_change_surface()) return {};
  const FeatureEdge* feature = m.feature(shell_.a, shell_.b);
  if (feature == nullptr) return surface ? EdgeKind::kSurface : EdgeKind::kInside;
  if (feature->has(kRequiredEdge)) return {};
  return surface ? EdgeKind::kRidge : EdgeKind::kLine;
}

bool Inserter::must_stay(const Shell& shell) const noexcept {
  const auto end = shell.tag.begin() + shell.ring_size();
  return std::any_of(shell.tag.begin(), end, [](FaceTag tag) { return (tag & kRequiredFace) != 0; });
}

bool Inserter::gather_other_fans(TetId t, VertId a, VertId b) {
  other_fans_.clear();
  const TetMesh& m = part_->mesh;
  const auto known = [&](TetId at) {
    const auto has = [&](const Shell& s) {
      return std::find(s.tet.begin(), s.tet.begin() + s.n, at) != s.tet.begin() + s.n;
    };
    return has(shell_) || std::any_of(other_fans_.begin(), other_fans_.end(), has);
  };
  fan_ball_.clear();
  if (!gather_ball(*part_, a, fan_ball_)) return false;
  for (const TetId at : fan_ball_) {
    if (!has_vertex(m.tet2vert[at], b) || at == t || known(at)) continue;
    Shell& fan = other_fans_.emplace_back();
    if (!gather_shell(m, at, a, b, fan) || fan.on_interface || must_stay(fan)) return false;
  }
  return true;
}

BoundaryPoint Inserter::place_on_edge(VertId a, VertId b, double s, EdgeKind kind) const {
  const Part& part = *part_;
  if (kind == EdgeKind::kInside) return {part.x(a) + s * (part.x(b) - part.x(a))};
  return part.geometry->between(part.mesh, a, b, s, kind);
}

void Inserter::split_facets(const Shell& shell, VertId p) {
  for (int i = 0; i < shell.ring_size(); ++i) {
    if (shell.tag[i] == 0) continue;
    cavity_->wall(shell.a, p, shell.ring[i], shell.tag[i]);
    cavity_->wall(p, shell.b, shell.ring[i], shell.tag[i]);
  }
}

void Inserter::split_boundary(VertId p) {
  split_facets(shell_, p);
  for (const Shell& fan : other_fans_) split_facets(fan, p);
  TetMesh& m = part_->mesh;
  const FeatureEdge* feature = m.feature(shell_.a, shell_.b);
  if (feature == nullptr) return;
  m.vert_ref[p] = feature->ref;
  m.vert_class[p] |= class_on(feature->edge_class);
  m.features.split(shell_.a, shell_.b, p);
}

InsertResult Inserter::on_edge(TetId t, VertId a, VertId b, double s) {
  Part& part = *part_;
  if (!gather_shell(part.mesh, t, a, b, shell_)) return InsertResult::kRefused;
  const auto kind = kind_of_edge();
  if (!kind) return InsertResult::kRefused;
  other_fans_.clear();
  const FeatureEdge* feature = *kind == EdgeKind::kRidge ? part.mesh.feature(a, b) : nullptr;
  if (feature != nullptr && feature->has(kContactEdge) && !gather_other_fans(t, a, b)) return InsertResult::kRefused;
  on_edge_ = true;
  BoundaryPoint at = place_on_edge(a, b, s, *kind);
  const InsertResult result = insert_on_edge(at, a, b, s, *kind);
  if (result != InsertResult::kRefused || *kind == EdgeKind::kInside) return result;
  // The surface may be where no element can follow yet. From the straight edge it is reached in steps.
  const Vec3 straight = part.x(a) + s * (part.x(b) - part.x(a));
  if (at.x == straight) return result;
  at.x = straight;
  return insert_on_edge(at, a, b, s, *kind);
}

InsertResult Inserter::insert_on_edge(const BoundaryPoint& at, VertId a, VertId b, double s, EdgeKind kind) {
  Part& part = *part_;
  cavity_->clear();
  for (int i = 0; i < shell_.n; ++i) cavity_->add(shell_.tet[i]);
  for (const Shell& fan : other_fans_) {
    for (int i = 0; i < fan.n; ++i) cavity_->add(fan.tet[i]);
  }
  const std::size_t seeds = cavity_->old_tets().size();
  const SymTensor log_m = (1 - s) * part.mesh.log_metric[a] + s * part.mesh.log_metric[b];
  const VertId p = new_vertex(part, at.x, log_m, class_on(kind));
  const InsertResult result = insert(p, seeds, part.closest_new);
  if (result != InsertResult::kDone) {
    drop_vertex(part, p);
    return result;
  }
  if (!part.mesh.surface_place.empty()) part.mesh.surface_place[p] = at.place;
  if (kind != EdgeKind::kInside) split_boundary(p);
  commit(p);
  ++part.counts.insert;
  return result;
}

InsertResult Inserter::inside(TetId t, const std::array<double, 4>& weight, double exclusion) {
  Part& part = *part_;
  if (part.must_stay(t)) return InsertResult::kRefused;
  const auto v = part.mesh.tet2vert[t];
  Vec3 x;
  SymTensor log_m;
  for (std::size_t i = 0; i < 4; ++i) {
    x += weight[i] * part.x(v[i]);
    log_m = log_m + weight[i] * part.mesh.log_metric[v[i]];
  }
  on_edge_ = false;
  cavity_->clear();
  cavity_->add(t);
  const VertId p = new_vertex(part, x, log_m, {});
  const InsertResult result = insert(p, 1, exclusion);
  if (result != InsertResult::kDone) {
    drop_vertex(part, p);
    return result;
  }
  commit(p);
  ++part.counts.insert;
  return result;
}

}  // namespace skein
