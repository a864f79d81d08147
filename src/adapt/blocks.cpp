// Blocks: labels and cutting.
#include "adapt/blocks.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/parallel.hpp"
#include "dist/partition.hpp"
#include "kernel/interface.hpp"

namespace skein {
namespace {

constexpr double kImbalance = 0.005;  ///< of the blocks' predicted work
constexpr double kIdle = 0.01;        ///< work in a tetrahedron that is not active

/// Faces to other ranks count as hull while this lives: the partitioner would look for what is behind them.
class WithoutOthers {
 public:
  explicit WithoutOthers(TetMesh& m) : m_(m) {
    for (const TetId t : IdRange<TetId>(m.tet_slots())) {
      for (std::size_t f = 0; f < 4; ++f) {
        if (m.tet2face[t][f] == kNoFace && !is_hull(m.face_tag[t][f])) faces_.push_back(make_face(t, f));
      }
    }
    flip();
  }
  WithoutOthers(const WithoutOthers&) = delete;
  WithoutOthers& operator=(const WithoutOthers&) = delete;
  ~WithoutOthers() { flip(); }

 private:
  void flip() noexcept {
    for (const FaceId f : faces_) m_.tag(f) ^= kHullFace;
  }
  TetMesh& m_;
  std::vector<FaceId> faces_;
};

}  // namespace

std::vector<std::int32_t> face_costs(const TetMesh& m, const MetricField& metric, int threads) {
  std::vector<std::int32_t> cost(4 * m.tet_slots(), 1);
  const auto of_face = [&](FaceId f) {
    const auto v = m.verts(f);
    const Vec3 a = m.coords[v[1]] - m.coords[v[0]], b = m.coords[v[2]] - m.coords[v[0]];
    double area = 0;
    for (const VertId w : v) {
      const SymTensor& g = metric.at[w].m;
      const double ab = dot(a, mul(g, b));
      area += std::sqrt(std::max(0.0, quad(g, a) * quad(g, b) - ab * ab)) / 6;
    }
    return static_cast<std::int32_t>(std::clamp(2 * area, 1.0, 1000.0));
  };
  threads = threads_for(cost.size(), threads);
  in_parallel(threads, [&](int w) {
    for (const FaceId f :
         IdRange<FaceId>(share_begin(cost.size(), w, threads), share_begin(cost.size(), w + 1, threads)))
      cost[idx(f)] = of_face(f);
  });
  return cost;
}

BlockLabels cut_blocks(TetMesh& m, const MetricField& metric, int blocks) {
  const auto cost = face_costs(m, metric, blocks);
  // The partitioner wants a rank's mesh: it is lent to one that has no others beside it.
  DistMesh alone;
  alone.data.width = 6;
  alone.data.values.reserve(6 * metric.size());
  for (const SymTensor& l : metric.log_at) {
    alone.data.values.insert(alone.data.values.end(), {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz});
  }
  alone.vert2gid.resize(m.vert_slots());
  for (const VertId v : IdRange<VertId>(m.vert_slots())) alone.vert2gid[v] = GlobalId{num(v)};
  alone.global_verts = static_cast<std::int64_t>(m.vert_slots());
  alone.global_tets = static_cast<std::int64_t>(m.tet_slots());
  alone.mesh = std::move(m);
  auto work = predicted_work(alone);
  for (const TetId t : IdRange<TetId>(alone.mesh.tet_slots())) {
    std::uint8_t flags = 0;
    for (const VertId v : alone.mesh.tet2vert[t]) flags |= alone.mesh.vert_flags[v];
    if ((flags & kActive) == 0) work[idx(t)] = kIdle;
  }
  MeshCutOptions options;
  options.face_weight = cost;
  options.imbalance = kImbalance;
  options.threads = blocks;
  const auto part = [&] {
    const WithoutOthers guard(alone.mesh);
    return multilevel_partition(Comm::self(), alone, work, blocks, options);
  }();
  m = std::move(alone.mesh);
  BlockLabels label(m.tet_slots());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) label[t] = num(part[t]);
  return label;
}

IdVector<VertId, char> between_blocks(const TetMesh& m, const BlockLabels& label) {
  IdVector<VertId, std::int32_t> first(m.vert_slots(), -1);
  IdVector<VertId, char> between(m.vert_slots(), 0);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (const VertId v : m.tet2vert[t]) {
      if (first[v] < 0) first[v] = label[t];
      if (first[v] != label[t]) between[v] = 1;
    }
  }
  return between;
}

namespace {

/// Vertices of the block in order of first appearance, and their flags.
void cut_vertices(const TetMesh& m, const MetricField& metric, const std::vector<TetId>& tets,
                  const IdVector<VertId, char>& between, IdVector<VertId, VertId>& to_block, Block& out) {
  Part& p = out.part;
  for (const TetId t : tets) {
    for (const VertId v : m.tet2vert[t]) {
      if (to_block[v] != kNoVert) continue;
      const VertId w = p.mesh.coords.push_back(m.coords[v]);
      to_block[v] = w;
      p.mesh.vert_ref.push_back(m.vert_ref[v]);
      auto flags = static_cast<std::uint8_t>(m.vert_flags[v] & ~kBesideFrozen);
      if ((flags & kFrozen) != 0) {
        out.frozen.push_back(w);
        out.frozen_of.push_back(v);
      }
      out.id.push_back(GlobalId{num(v)});
      if (between[v] != 0) {
        out.common.push_back(w);
        flags |= kFrozen;
      }
      p.mesh.vert_flags.push_back(flags);
      p.mesh.vert2tet.push_back(kNoTet);
      p.metric.at.push_back(metric.at[v]);
      p.metric.log_at.push_back(metric.log_at[v]);
    }
  }
}

void cut_features(const TetMesh& m, TetId t, const IdVector<VertId, VertId>& to_block, FeatureEdges& features) {
  const auto& tv = m.tet2vert[t];
  for (const auto& e : kEdgeVerts) {
    const VertId a = tv[e[0]], b = tv[e[1]];
    if (!m.has(a, kRidge) || !m.has(b, kRidge)) continue;
    const FeatureEdge* f = m.features.find(a, b);
    if (f != nullptr) features.insert(to_block[a], to_block[b], f->ref, f->ridge);
  }
}

}  // namespace

Block cut_block(const TetMesh& m, const MetricField& metric, const BlockLabels& label,
                const IdVector<VertId, char>& between, int b) {
  Block out;
  std::vector<TetId> tets;
  IdVector<TetId, TetId> tet2block(m.tet_slots(), kNoTet);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (label[t] != b) continue;
    tet2block[t] = to_id<TetId>(tets.size());
    tets.push_back(t);
  }
  IdVector<VertId, VertId> to_block(m.vert_slots(), kNoVert);
  cut_vertices(m, metric, tets, between, to_block, out);
  TetMesh& bm = out.part.mesh;
  bm.tet2vert.reserve(tets.size());
  bm.tet2face.reserve(tets.size());
  for (const TetId t : tets) {
    std::array<VertId, 4> tv;
    std::array<FaceId, 4> tf;
    for (std::size_t i = 0; i < 4; ++i) {
      tv[i] = to_block[m.tet2vert[t][i]];
      const FaceId nb = m.tet2face[t][i];
      const bool inside = nb != kNoFace && tet2block[face_tet(nb)] != kNoTet;
      tf[i] = inside ? make_face(tet2block[face_tet(nb)], face_side(nb)) : kNoFace;
    }
    const TetId bt = bm.tet2vert.push_back(tv);
    bm.tet2face.push_back(tf);
    for (const VertId v : tv) bm.vert2tet[v] = bt;
    bm.face_tag.push_back(m.face_tag[t]);
    bm.tet_ref.push_back(m.tet_ref[t]);
    cut_features(m, t, to_block, bm.features);
  }
  bm.patch_ref = m.patch_ref;
  return out;
}

void follow(Block& block, const IdVector<VertId, VertId>& old2new) {
  IdVector<VertId, GlobalId> id(block.part.mesh.vert_slots(), kNoGlobal);
  for (VertId& v : block.common) {
    id[old2new[v]] = block.id[v];
    v = old2new[v];
  }
  for (VertId& v : block.frozen) v = old2new[v];
  block.id = std::move(id);
}

bool refine_block_interface(Block& block, double times) {
  const std::size_t before = block.part.mesh.vert_slots();
  const auto free = std::exchange(block.part.free_verts, {});  // what is new shall be at the end
  constexpr std::uint8_t kWasFrozen = kBesideFrozen;           // which is the kernel's, and not in use yet
  const int keep = kWasFrozen | (block.part.options.may_change_surface() ? 0 : kSurface);
  auto& flags = block.part.mesh.vert_flags;
  for (const VertId v : block.frozen) flags[v] |= kWasFrozen;
  const bool refined = refine_interface(block.part, block.id, static_cast<std::uint8_t>(keep), times);
  for (const VertId v : block.frozen) flags[v] = static_cast<std::uint8_t>(flags[v] & ~kWasFrozen);
  if (!refined) return false;
  block.part.free_verts = free;
  for (std::size_t i = before; i < block.part.mesh.vert_slots(); ++i) block.common.push_back(to_id<VertId>(i));
  return true;
}

}  // namespace skein
