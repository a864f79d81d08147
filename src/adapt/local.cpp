// Adapting one rank's mesh with its threads.
#include "adapt/local.hpp"

#include <algorithm>

#include "adapt/band.hpp"
#include "adapt/blocks.hpp"
#include "adapt/gaps.hpp"
#include "base/assert.hpp"
#include "base/parallel.hpp"
#include "kernel/recipe.hpp"
#include "mesh/check.hpp"

namespace skein {
namespace {

void set_up(Part& part, const LocalOptions& o) {
  part.options = o.kernel;
  part.spacing = o.spacing;
  part.geometry = o.geometry;
  prepare(part);
}

IdVector<VertId, VertId> run(Part& part) {
  auto old2new = adapt_part(part);
  SKEIN_ASSERT_NO_FAULT_AT(3, check(part.mesh));
  return old2new;
}

IdVector<VertId, VertId> identity_of_frozen(const TetMesh& mesh) {
  IdVector<VertId, VertId> out(mesh.vert_slots(), kNoVert);
  for (const VertId v : IdRange<VertId>(mesh.vert_slots())) {
    if (mesh.has(v, kFrozen)) out[v] = v;
  }
  return out;
}

void run_alone(TetMesh& mesh, const LocalOptions& o, LocalResult& result) {
  Part part;
  part.mesh = std::move(mesh);
  set_up(part, o);
  const auto adapted = run(part);
  result.counts += part.counts;
  result.turning = part.turning;
  mesh = std::move(part.mesh);
  const auto now = close_gaps(mesh);
  for (auto& v : result.old2new) {
    if (v != kNoVert) v = now[adapted[v]];
  }
}

/// The coordinate along which points extend furthest, as a function of a point.
auto longest_axis(const std::vector<Vec3>& points) {
  Vec3 low = points.front(), high = low;
  for (const Vec3& x : points) {
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  const Vec3 d = high - low;
  double Vec3::*const axis = d.x >= d.y && d.x >= d.z ? &Vec3::x : d.y >= d.z ? &Vec3::y : &Vec3::z;
  return [axis](const Vec3& x) { return x.*axis; };
}

/// More than a tenth of the vertices, now or in the end, are frozen: a small part inside a refined interface. Cutting
/// that once more gives blocks that are all interface, whose needles cost more than the threads gain.
bool mostly_interface(const TetMesh& mesh, std::int64_t one_in) {
  std::int64_t frozen = 0;
  for (const VertState s : mesh.vert_state) frozen += any(s & kFrozen) ? 1 : 0;
  return one_in * frozen > std::ssize(mesh.vert_state.raw()) && one_in * frozen > expected_points(mesh);
}

/// Slabs of equal numbers of tetrahedra across the longest side of the mesh: for a band, in which there is so little to
/// do that a better cut would cost more than the work.
BlockLabels cut_slabs(const TetMesh& mesh, int slabs) {
  const auto along = longest_axis(mesh.coords.raw());
  const std::size_t n = mesh.tet_slots();
  std::vector<double> place(n);
  for (const TetId t : IdRange<TetId>(n)) {
    for (const VertId v : mesh.tet2vert[t]) place[idx(t)] += along(mesh.coords[v]);
  }
  BlockLabels label(n, 0);
  std::vector<double> sorted = place;
  for (int b = 1; b < slabs; ++b) {
    const auto begin = sorted.begin() + static_cast<std::ptrdiff_t>(share_begin(n, b - 1, slabs));
    const auto bound = sorted.begin() + static_cast<std::ptrdiff_t>(share_begin(n, b, slabs));
    std::nth_element(begin, bound, sorted.end());
    for (std::size_t t = 0; t < n; ++t) label.raw()[t] += place[t] >= *bound ? 1 : 0;
  }
  return label;
}

/// One turn of all blocks in parallel. Updates old2new of frozen vertices and gives the vertices between the blocks.
std::vector<VertId> run_blocks(TetMesh& mesh, const BlockLabels& label, const LocalOptions& o, LocalResult& result) {
  const auto between = between_blocks(mesh, label);
  // A band grows by little, and all is put behind the first block in the end.
  const auto points = o.kernel.only_retry() ? mesh.vert_slots() : static_cast<std::size_t>(expected_points(mesh));
  // Points are created in two steps, and the interface is refined for each of them; to what is frozen, which is as it
  // is, in one, so that splits come as near to it as they may.
  const bool in_steps =
      !o.kernel.only_retry() && o.kernel.may_change_surface() &&
      std::all_of(result.old2new.begin(), result.old2new.end(), [](VertId v) { return v == kNoVert; });
  const auto share = points / static_cast<std::size_t>(o.threads);
  std::vector<Block> blocks(static_cast<std::size_t>(o.threads));
  std::vector<char> refined(blocks.size(), 0);
  const auto of = [](auto& list, int b) -> auto& { return list[b]; };
  const auto start = [&](int b) -> Block& {
    Block& block = of(blocks, b);
    block = cut_block(mesh, label, between, b);
    reserve(block.part, b == 0 ? points : share);
    set_up(block.part, o);
    return block;
  };
  const auto take_first_step = [&](Block& block) {
    if (!refine_block_interface(block, o.kernel.method.lengths.first_step)) return false;
    follow(block, create_coarse_points(block.part));
    return true;
  };
  in_parallel(o.threads, [&](int b) {
    Block& block = start(b);
    of(refined, b) = (!in_steps || take_first_step(block)) && refine_block_interface(block) ? 1 : 0;
  });
  const std::size_t old_verts = mesh.vert_slots();
  const bool coarse = std::find(refined.begin(), refined.end(), 0) != refined.end();  // all or none
  if (coarse) in_parallel(o.threads, [&](int b) { start(b); });
  mesh = TetMesh{};
  in_parallel(o.threads, [&](int b) {
    Block& block = of(blocks, b);
    seal_block(block, run(block.part));
  });
  for (const Block& b : blocks) {
    result.counts += b.part.counts;
    result.turning = result.turning || b.part.turning;
  }
  Merged merged = merge_blocks(blocks, old_verts);
  for (auto& v : result.old2new) {
    if (v != kNoVert) v = merged.old2new[v];
  }
  mesh = std::move(merged.mesh);
  return std::move(merged.between);
}

bool is_good(const TetMesh& m, TetId t, double quality) noexcept {
  const auto& v = m.tet2vert[t];
  const auto x = [&](std::size_t i) { return m.coords[v[i]]; };
  const auto g = [&](std::size_t i) -> const VertMetric& { return m.metric[v[i]]; };
  return quality_cubed(x(0), x(1), x(2), x(3), g(0), g(1), g(2), g(3)) >= cube(quality);
}

/// Works on what the interfaces between blocks have retry back: the band round them is cut out, adapted and put back.
void run_between(TetMesh& mesh, const std::vector<VertId>& between, const LocalOptions& o, LocalResult& result) {
  std::vector<VertId> frozen;
  for (const VertId v : result.old2new) {
    if (v != kNoVert) frozen.push_back(v);
  }
  for (const VertId v : between) mesh.vert_state[v] |= kRetry;
  std::vector<VertId> retry;
  for (const VertId v : IdRange<VertId>(mesh.vert_slots())) {
    if (mesh.has(v, kRetry)) retry.push_back(v);
  }
  Surroundings near(mesh, std::move(retry));
  // One vertex further, but where everything is well already.
  near.add_tets();
  near.add_vertices([&](TetId t) { return !is_good(mesh, t, o.kernel.method.retry.good_quality); });
  Band band = cut_band(mesh, std::move(near), o.threads);
  LocalOptions of_band = o;
  of_band.kernel.scope = Scope::kRetry;
  if (2 * band.mesh.tet_slots() > mesh.tet_slots()) of_band.threads = 1;
  const LocalResult r = adapt_local(band.mesh, of_band);
  result.counts += r.counts;
  put_back(mesh, band, r.old2new, frozen, o.threads);
  auto next = frozen.begin();
  for (VertId& v : result.old2new) {
    if (v != kNoVert) v = *next++;
  }
}

}  // namespace

LocalResult adapt_local(TetMesh& mesh, const LocalOptions& o) {
  SKEIN_ASSERT_NO_FAULT_AT(2, check_sizes(mesh));
  SKEIN_ASSERT_NO_FAULT_AT(3, check(mesh));
  LocalResult result;
  result.old2new = identity_of_frozen(mesh);
  if (mesh.tet_slots() == 0) return result;
  const Method::Threads& method = o.kernel.method.threads;
  const bool band = o.kernel.only_retry();  // nearly as it shall be, so its cut needs no refinement
  if (o.threads <= 1 ||
      mesh.tet_slots() < static_cast<std::size_t>(band ? method.smallest_band : method.smallest_block) *
                             static_cast<std::size_t>(o.threads) ||
      (!band && mostly_interface(mesh, method.frozen_one_in))) {
    run_alone(mesh, o, result);
  } else {
    const auto label = band ? cut_slabs(mesh, o.threads) : cut_blocks(mesh, o.threads, method);
    const auto between = run_blocks(mesh, label, o, result);
    run_between(mesh, between, o, result);
  }
  return result;
}

}  // namespace skein
