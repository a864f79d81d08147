// What the tagged faces at feature edges say of them and of their vertices.
#include <algorithm>
#include <limits>
#include <tuple>

#include "base/hash.hpp"
#include "comm/halo.hpp"
#include "dist/distribute_steps.hpp"
#include "dist/sharing.hpp"

namespace skein::distributing {
namespace {

/// The tagged faces at one feature edge.
struct FacesAtEdge {
  std::int32_t all = 0, hull = 0;
  std::uint64_t kinds = 0;  ///< of the set of their patches: a sum over the faces
  FacesAtEdge& operator+=(const FacesAtEdge& o) noexcept {
    all += o.all, hull += o.hull, kinds += o.kinds;
    return *this;
  }
};

/// Of this rank's faces, by the places of the features in their list.
std::vector<FacesAtEdge> count_here(const Growing& g) {
  const TetMesh& m = g.dist.mesh;
  std::vector<FacesAtEdge> out(m.features.size());
  if (out.empty()) return out;
  for (const FaceId f : g.speakers) {
    const auto v = m.verts(f);
    const FaceTag tag = m.tag(f);
    const FacesAtEdge one{1, is_hull(tag) ? 1 : 0, mix(tag & (kPatchMask | kHullFace))};
    for (std::size_t k = 0; k < 3; ++k) {
      const FeatureEdge* e = m.feature(v[k], v[(k + 1) % 3]);
      if (e != nullptr) out[static_cast<std::size_t>(e - m.features.list().data())] += one;
    }
  }
  return out;
}

/// One rank's count at an edge that another may have, too.
struct PartialCount {
  GlobalId a, b;
  FacesAtEdge faces;
};

/// Collective. Adds what other ranks have.
void add_other_ranks(const Comm& comm, const Growing& g, std::vector<FacesAtEdge>& count) {
  const auto& list = g.dist.mesh.features.list();
  std::vector<std::size_t> shared;
  std::vector<Rank> dest;
  std::vector<PartialCount> counts;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (g.many[list[i].a] == 0 || g.many[list[i].b] == 0) continue;
    const auto [a, b] = std::minmax(g.dist.vert2gid[list[i].a], g.dist.vert2gid[list[i].b]);
    shared.push_back(i);
    dest.push_back(meeting_rank(a, comm.size()));
    counts.push_back({a, b, count[i]});
  }
  const Inquiry<PartialCount> inquiry(comm, dest, counts);
  const auto& met = inquiry.asked().items;
  std::vector<std::size_t> order(met.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto key = [&](std::size_t i) { return std::tie(met[i].a, met[i].b); };
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return key(i) < key(j); });
  std::vector<FacesAtEdge> sums(met.size());
  for (std::size_t i = 0, j = 0; i < order.size(); i = j) {
    FacesAtEdge sum;
    for (j = i; j < order.size() && key(order[j]) == key(order[i]); ++j) sum += met[order[j]].faces;
    for (std::size_t k = i; k < j; ++k) sums[order[k]] = sum;
  }
  const auto answer = inquiry.answer(sums);
  for (std::size_t i = 0; i < shared.size(); ++i) count[shared[i]] = answer[i];
}

FeatureClass class_by_faces(const FacesAtEdge& faces) noexcept {
  return (faces.all <= 1 ? kThinEdge : FeatureClass{}) | (faces.hull > 2 ? kContactEdge : FeatureClass{});
}

/// Collective. Corners: where features with different faces meet, and where a line inside a region meets a surface.
void add_corners(const Comm& comm, Growing& g, const std::vector<FacesAtEdge>& count) {
  TetMesh& m = g.dist.mesh;
  // The least and the largest of FacesAtEdge::kinds over the features at each vertex.
  std::vector<std::int64_t> low(m.vert_slots(), std::numeric_limits<std::int64_t>::max());
  std::vector<std::int64_t> high(m.vert_slots(), -1);
  const auto& list = m.features.list();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].has(kImpliedEdge)) continue;
    const auto kinds = static_cast<std::int64_t>(count[i].kinds >> 1);
    for (const VertId v : {list[i].a, list[i].b}) {
      low[idx(v)] = std::min(low[idx(v)], kinds);
      high[idx(v)] = std::max(high[idx(v)], kinds);
    }
  }
  const Halo halo(comm, g.dist.sharing);
  halo.max(std::span<std::int64_t>(high));
  halo.min(std::span<std::int64_t>(low));
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const std::int64_t least = low[idx(v)], most = high[idx(v)];
    if (least > most) continue;  // no features
    if (least != most || (most == 0 && m.has(v, kSurface))) m.vert_class[v] |= kCorner;
  }
}

}  // namespace

void classify_features(const Comm& comm, Growing& g) {
  TetMesh& m = g.dist.mesh;
  auto count = count_here(g);
  add_other_ranks(comm, g, count);
  FeatureEdges classified;
  for (std::size_t i = 0; i < count.size(); ++i) {
    FeatureEdge e = m.features.list()[i];
    e.edge_class |= class_by_faces(count[i]);
    classified.insert(e);
    for (const VertId v : {e.a, e.b}) m.vert_class[v] |= class_on(e.edge_class);
  }
  m.features = std::move(classified);
  merge_vertex_flags(comm, g.dist);  // a rank may have a vertex on a surface without a face of it
  add_corners(comm, g, count);
}

}  // namespace skein::distributing
