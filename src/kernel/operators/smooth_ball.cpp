// The ball of the vertex at hand: its elements, where it may go, and the metric there.
#include <algorithm>
#include <numeric>

#include "kernel/operators/smooth.hpp"

namespace skein {
namespace {
constexpr std::size_t kMaxBall = 500;  ///< tetrahedra; a vertex with more of them stays
}

template <std::size_t N>
bool Smoother::note_ridge_ends(VertId v, const std::array<VertId, N>& verts) {
  const TetMesh& m = part_->mesh;
  for (const VertId w : verts) {
    if (w == v || !m.has(w, kRidge | kCorner) || m.features.find(v, w) == nullptr) continue;
    auto& ends = star_.ridge_ends;
    if (ends[0] == kNoVert || ends[0] == w) {
      ends[0] = w;
    } else if (ends[1] == kNoVert || ends[1] == w) {
      ends[1] = w;
    } else {
      return false;
    }
  }
  return true;
}

bool Smoother::note_facets(VertId v, FaceId at) {
  const TetMesh& m = part_->mesh;
  const TetId t = face_tet(at);
  for (std::size_t f = 0; f < 4; ++f) {
    const FaceTag tag = m.face_tag[t][f];
    if (tag == 0 || f == face_side(at)) continue;
    if ((tag & kRequiredFace) != 0) return false;
    const auto k = m.verts(make_face(t, f));
    facets_.push_back(k);
    if (m.has(v, kRidge) && !note_ridge_ends(v, k)) return false;
  }
  return true;
}

bool Smoother::find_freedom(VertId v, Freedom& free) {
  const TetMesh& m = part_->mesh;
  free = {};
  if (!m.has(v, kSurface | kRidge)) return true;
  if (!part_->options.may_change_surface()) return false;
  facets_.clear();
  star_.ridge_ends = {kNoVert, kNoVert};
  const bool line = !m.has(v, kSurface);  // inside a region
  for (const FaceId at : ball_) {
    if (line ? !note_ridge_ends(v, m.verts(at)) : !note_facets(v, at)) return false;
  }
  star_.facets = facets_;
  const auto found = part_->geometry->freedom(m, v, star_);
  if (found) free = *found;
  return found.has_value();
}

bool Smoother::gather(VertId v, Ball& ball) {
  const Part& p = *part_;
  if (p.mesh.has(v, kFrozen) || p.mesh.has(v, kStays) || !find_ball(v) || !find_freedom(v, ball.free)) return false;
  cone_.clear();
  for (const FaceId f : ball_) {
    const auto k = p.mesh.verts(f);
    cone_.add(p, k[0], k[1], k[2]);
    const double q = p.q3[face_tet(f)];
    ball.sum += 1 / std::max(q, 1e-30);
    ball.low = std::min(ball.low, q);
  }
  return true;
}

bool Smoother::interpolate_from_anchor(VertId v, Vec3 x, SymTensor& log_m) {
  const auto& [from, log_from] = part_->mesh.anchor[v];
  const Cone::Place place = cone_.locate(from, x - from);
  const auto k = part_->mesh.verts(ball_[place.face]);
  const auto& w = place.weight;
  const double rest = 1 - w[0] - w[1] - w[2];
  constexpr double kRounding = -1e-6;
  if (!(w[0] > kRounding) || !(w[1] > kRounding) || !(w[2] > kRounding) || !(rest > kRounding)) return false;
  if (!(volume6(from, part_->x(k[0]), part_->x(k[1]), part_->x(k[2])) > 0)) return false;
  log_m = rest * log_from;
  for (std::size_t i = 0; i < 3; ++i) log_m = log_m + w[i] * part_->mesh.log_metric[k[i]];
  return true;
}

bool Smoother::interpolate(VertId v, Vec3 step, SymTensor& log_m) {
  if (!part_->mesh.anchor.empty() && interpolate_from_anchor(v, part_->x(v) + step, log_m)) return true;
  const Cone::Place place = cone_.locate(part_->x(v), step);
  const auto k = part_->mesh.verts(ball_[place.face]);
  double rest = 1;
  log_m = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const double w = std::max(place.weight[i], 0.0);
    rest -= w;
    log_m = log_m + w * part_->mesh.log_metric[k[i]];
  }
  if (rest < -0.1) return false;  // beyond the ball
  log_m = (1 / (1 - std::min(rest, 0.0))) * (log_m + std::max(rest, 0.0) * part_->mesh.log_metric[v]);
  return true;
}

std::size_t Smoother::list_link(VertId v) {
  Part& p = *part_;
  if (link_.size() < 4 * ball_.size()) link_.resize(4 * ball_.size());
  const std::uint32_t stamp = ++p.vert_stamp;
  p.vert_mark[v] = stamp;
  std::size_t n = 0;
  for (const FaceId f : ball_) {
    for (const VertId w : p.mesh.tet2vert[face_tet(f)]) {
      link_[n] = w;
      n += p.vert_mark[w] != stamp ? 1 : 0;
      p.vert_mark[w] = stamp;
    }
  }
  return n;
}

void Smoother::mark_changed(VertId v) {
  Part& p = *part_;
  const std::size_t n = list_link(v);
  p.edge_class[v] = 0;
  unsigned any = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t bits = p.classify(v, link_[i]);
    p.edge_class[link_[i]] = bits;
    any |= bits;
  }
  for (std::size_t i = 0; i < ball_.size(); ++i) {
    const TetId t = face_tet(ball_[i]);
    p.q3[t] = static_cast<float>(cone_.q3(i));
    p.dirty[t] = kAnew;
    const auto& tv = p.mesh.tet2vert[t];
    const auto& edge_of = kEdgeOf[face_side(ball_[i])];
    EdgeBits edges = p.edges[t];
    edges.keep(~(1U << edge_of[0] | 1U << edge_of[1] | 1U << edge_of[2] | 1U << edge_of[3]));
    for (std::size_t k = 0; any != 0 && k < 4; ++k) edges.add(edge_of[k], p.edge_class[tv[k]]);
    p.edges[t] = edges;
  }
}

void Smoother::index_balls() {
  const TetMesh& m = part_->mesh;
  first_.assign(m.vert_slots() + 1, 0);
  for (const auto& tv : m.tet2vert) {
    if (tv[0] == kNoVert) continue;
    for (const VertId v : tv) ++first_[idx(v) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  balls_.resize(static_cast<std::size_t>(first_.back()));
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.is_live(t)) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      balls_[static_cast<std::size_t>(first_[idx(m.tet2vert[t][k])]++)] = make_face(t, k);
    }
  }
  // Every start has moved to the next one's.
  std::move_backward(first_.begin(), first_.end() - 1, first_.end());
  first_.front() = 0;
}

void Smoother::drop_index() noexcept { first_.clear(); }

void Smoother::fetch_ball(VertId v) const noexcept {
  for (const FaceId f : indexed_ball(v)) {
    __builtin_prefetch(&part_->mesh.tet2vert[face_tet(f)]);
    __builtin_prefetch(&part_->q3[face_tet(f)]);
  }
}

void Smoother::fetch_vertices(VertId v) const noexcept {
  for (const FaceId f : indexed_ball(v)) {
    for (const VertId w : part_->mesh.tet2vert[face_tet(f)]) {
      __builtin_prefetch(&part_->mesh.coords[w]);
      __builtin_prefetch(&part_->mesh.metric[w].sqrt_det);
    }
  }
}

std::span<const FaceId> Smoother::indexed_ball(VertId v) const noexcept {
  if (first_.empty()) return {};
  const auto begin = first_[idx(v)], end = first_[idx(v) + 1];
  return {balls_.data() + begin, static_cast<std::size_t>(end - begin)};
}

bool Smoother::find_ball(VertId v) {
  ball_.clear();
  if (first_.empty()) {
    tets_.clear();
    if (!gather_ball(*part_, v, tets_, kMaxBall)) return false;
    for (const TetId t : tets_) ball_.push_back(make_face(t, local_index(part_->mesh.tet2vert[t], v)));
    return true;
  }
  const auto ball = indexed_ball(v);
  if (ball.size() > kMaxBall) return false;
  ball_.assign(ball.begin(), ball.end());
  return true;
}

}  // namespace skein
