// Blocks: labels and cutting.
#include "adapt/blocks.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/parallel.hpp"
#include "dist/dual_graph.hpp"
#include "dist/partition.hpp"
#include "kernel/interface.hpp"
#include "partition/multilevel.hpp"

namespace skein {
std::vector<std::int32_t> face_costs(const TetMesh& m, int threads) {
  std::vector<std::int32_t> cost(4 * m.tet_slots(), 1);
  const auto of_face = [&](FaceId f) {
    const auto v = m.verts(f);
    const Vec3 a = m.coords[v[1]] - m.coords[v[0]], b = m.coords[v[2]] - m.coords[v[0]];
    double area = 0;
    for (const VertId w : v) {
      const SymTensor& g = m.metric[w].m;
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

BlockLabels cut_blocks(const TetMesh& m, int blocks, const Method::Threads& method) {
  const auto cost = face_costs(m, blocks);
  auto work = predicted_work(m);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const auto& v = m.tet2vert[t];
    if (std::none_of(v.begin(), v.end(), [&](VertId w) { return m.has(w, kActive); })) work[idx(t)] = method.idle_work;
  }
  const auto part = multilevel_partition(Comm::self(), dual_graph(m, work, cost, blocks), blocks,
                                         MultilevelOptions{.imbalance = method.block_imbalance, .threads = blocks});
  BlockLabels label(m.tet_slots());
  for (const TetId t : IdRange<TetId>(m.tet_slots())) label[t] = num(part.raw()[idx(t)]);
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

/// Vertices of the block in order of first appearance.
void cut_vertices(const TetMesh& m, const std::vector<TetId>& tets, const IdVector<VertId, char>& between,
                  IdVector<VertId, VertId>& to_block, Block& out) {
  std::vector<VertId> verts;
  for (const TetId t : tets) {
    for (const VertId v : m.tet2vert[t]) {
      if (to_block[v] != kNoVert) continue;
      to_block[v] = to_id<VertId>(verts.size());
      verts.push_back(v);
    }
  }
  TetMesh& b = out.part.mesh;
  for_each_vert_column(b, m, [&](auto& to, const auto& from) { gather_column(to, from, verts); });
  b.vert2tet.assign(verts.size(), kNoTet);
  out.id.reserve(verts.size());
  for (const VertId v : verts) out.id.push_back(GlobalId{num(v)});
  for (const VertId w : IdRange<VertId>(verts.size())) {
    const VertId v = verts[idx(w)];
    b.vert_state[w] &= ~kBesideFrozen;
    if (m.has(v, kFrozen)) {
      out.frozen.push_back(w);
      out.frozen_of.push_back(v);
    }
    if (between[v] != 0) {
      out.common.push_back(w);
      b.vert_state[w] |= kFrozen;
    }
  }
}

void cut_features(const TetMesh& m, TetId t, const IdVector<VertId, VertId>& to_block, FeatureEdges& features) {
  const auto& tv = m.tet2vert[t];
  for (const auto& e : kEdgeVerts) {
    const VertId a = tv[e[0]], b = tv[e[1]];
    if (!m.has(a, kRidge) || !m.has(b, kRidge)) continue;
    const FeatureEdge* f = m.features.find(a, b);
    if (f != nullptr) features.insert({to_block[a], to_block[b], f->ref, f->edge_class});
  }
}

}  // namespace

Block cut_block(const TetMesh& m, const BlockLabels& label, const IdVector<VertId, char>& between, int b) {
  Block out;
  std::vector<TetId> tets;
  IdVector<TetId, TetId> tet2block(m.tet_slots(), kNoTet);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (label[t] != b) continue;
    tet2block[t] = to_id<TetId>(tets.size());
    tets.push_back(t);
  }
  IdVector<VertId, VertId> to_block(m.vert_slots(), kNoVert);
  cut_vertices(m, tets, between, to_block, out);
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
    bm.tet_class.push_back(m.tet_class[t]);
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
  const KeptVerts keep{block.part.options.may_change_surface() ? VertClass{} : kSurface, kWasFrozen};
  auto& state = block.part.mesh.vert_state;
  for (const VertId v : block.frozen) state[v] |= kWasFrozen;
  const bool refined = refine_interface(block.part, block.id, keep, times);
  for (const VertId v : block.frozen) state[v] &= ~kWasFrozen;
  if (!refined) return false;
  block.part.free_verts = free;
  for (std::size_t i = before; i < block.part.mesh.vert_slots(); ++i) block.common.push_back(to_id<VertId>(i));
  return true;
}

}  // namespace skein
