// Adapting one rank's mesh with its threads.
#include "adapt/local.hpp"

#include <algorithm>
#include <exception>
#include <thread>

#include "adapt/blocks.hpp"
#include "kernel/passes.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/assert.hpp"
#include "mesh/check.hpp"

namespace skein {
namespace {

constexpr int kLayers = 3;               ///< by which interfaces of blocks move
constexpr int kActiveLayers = 2;         ///< round old interfaces that are worked on again
constexpr std::size_t kSmallest = 2000;  ///< tetrahedra per thread below which threads do not pay

IdVector<VertId, VertId> run(Part& part, const LocalOptions& o) {
  part.options = o.kernel;
  part.spacing = o.spacing;
  prepare(part);
  auto old2new = adapt_part(part);
  SKEIN_ASSERT_NO_FAULT_AT(3, check(part.mesh));
  return old2new;
}

/// Takes the free slots out of mesh and metric; follows the numbers in old2new.
void squeeze_all(TetMesh& mesh, MetricField& metric, IdVector<VertId, VertId>& old2new) {
  const auto step = squeeze(mesh);
  squeeze(metric.at, step, mesh.vert_slots());
  squeeze(metric.log_at, step, mesh.vert_slots());
  for (auto& v : old2new) {
    if (v != kNoVert) v = step[v];
  }
}

IdVector<VertId, VertId> identity_of_frozen(const TetMesh& mesh) {
  IdVector<VertId, VertId> out(mesh.vert_slots(), kNoVert);
  for (const VertId v : IdRange<VertId>(mesh.vert_slots())) {
    if (mesh.has(v, kFrozen)) out[v] = v;
  }
  return out;
}

void run_alone(TetMesh& mesh, MetricField& metric, const LocalOptions& o, LocalResult& result) {
  Part part;
  part.mesh = std::move(mesh);
  part.metric = std::move(metric);
  const auto step = run(part, o);
  for (auto& v : result.old2new) {
    if (v != kNoVert) v = step[v];
  }
  result.counts += part.counts;
  mesh = std::move(part.mesh);
  metric = std::move(part.metric);
}

constexpr std::size_t to_index(int b) noexcept { return static_cast<std::size_t>(b); }

/// Calls work(b) for every block in a thread of its own; the first exception (by block) is thrown again.
template <class Work>
void in_parallel(int threads, Work&& work) {
  std::vector<std::exception_ptr> failed(to_index(threads));
  const auto guarded = [&](int b) noexcept {
    try {
      work(b);
    } catch (...) {
      failed[to_index(b)] = std::current_exception();
    }
  };
  // Threads of the standard library, because ThreadSanitizer understands them; a few of them live for seconds each.
  {
    std::vector<std::jthread> others;
    for (int b = 1; b < threads; ++b) others.emplace_back(guarded, b);
    guarded(0);
  }
  for (const auto& e : failed) {
    if (e) std::rethrow_exception(e);
  }
}

/// More than a tenth of the vertices are frozen: a small part inside a refined interface. Cutting that once more gives
/// blocks that are all interface, whose needles cost more than the threads gain.
bool mostly_interface(const TetMesh& mesh) {
  std::size_t frozen = 0;
  for (const auto f : mesh.vert_flags) frozen += (f & kFrozen) != 0 ? 1 : 0;
  return 10 * frozen > mesh.vert_slots();
}

/// One turn of all blocks in parallel. Updates old2new of frozen vertices and gives the labels of the result.
BlockLabels run_blocks(TetMesh& mesh, MetricField& metric, const BlockLabels& label, const LocalOptions& o,
                       LocalResult& result) {
  const auto between = between_blocks(mesh, label);
  std::vector<Block> blocks(static_cast<std::size_t>(o.threads));
  std::vector<char> refined(blocks.size(), 0);
  in_parallel(o.threads, [&](int b) {
    Block& block = blocks[to_index(b)];
    block = cut_block(mesh, metric, label, between, b);
    block.part.options = o.kernel;
    block.part.spacing = o.spacing;
    prepare(block.part);
    refined[to_index(b)] = refine_block_interface(block) ? 1 : 0;
  });
  const std::size_t old_verts = mesh.vert_slots();
  if (std::find(refined.begin(), refined.end(), 0) != refined.end()) {  // all or none
    in_parallel(o.threads, [&](int b) { blocks[to_index(b)] = cut_block(mesh, metric, label, between, b); });
  }
  mesh = TetMesh{};
  metric = MetricField{};
  in_parallel(o.threads, [&](int b) {
    Block& block = blocks[to_index(b)];
    renumber_common(block, run(block.part, o));
  });
  for (const Block& b : blocks) result.counts += b.part.counts;
  Merged merged = merge_blocks(blocks, old_verts);
  for (auto& v : result.old2new) {
    if (v != kNoVert) v = merged.old2new[v];
  }
  mesh = std::move(merged.mesh);
  metric = std::move(merged.metric);
  return std::move(merged.label);
}

}  // namespace

LocalResult adapt_local(TetMesh& mesh, MetricField& metric, const LocalOptions& o) {
  LocalResult result;
  result.old2new = identity_of_frozen(mesh);
  if (mesh.tet_slots() == 0) return result;
  if (o.threads <= 1 || mesh.tet_slots() < kSmallest * static_cast<std::size_t>(o.threads) || mostly_interface(mesh)) {
    run_alone(mesh, metric, o, result);
  } else {
    BlockLabels label = run_blocks(mesh, metric, cut_blocks(mesh, metric, o.threads), o, result);
    // Two turns suffice for two blocks; where three meet, a third one takes what the second had to leave.
    const int turns = o.threads == 2 ? 1 : 2;
    for (int turn = 1; turn <= turns; ++turn) {
      keep_active_near_blocks(mesh, label, kActiveLayers);
      label = run_blocks(mesh, metric, displace_blocks(mesh, label, o.threads, kLayers, turn), o, result);
    }
  }
  squeeze_all(mesh, metric, result.old2new);
  return result;
}

}  // namespace skein
