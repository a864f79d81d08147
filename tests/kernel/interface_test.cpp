// refine_interface: parts that do not talk to each other make the same interface.
#include "kernel/interface.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "mesh/check.hpp"
#include "tests/kernel/judge.hpp"
#include "tests/kernel/metrics.hpp"

namespace skein::test {
namespace {

using Triple = std::array<GlobalId, 3>;
struct Corner {
  Vec3 x;
  SymTensor log_m;
  VertClass surface;
};
/// A part's interface: its faces, and what is at its vertices.
struct Interface {
  std::multiset<Triple> faces;
  std::map<GlobalId, Corner> corners;
};

Interface interface_of(const Part& p, const IdVector<VertId, GlobalId>& gid) {
  Interface out;
  for (const auto& f : interface_faces(p.mesh)) {
    Triple t{gid[f[0]], gid[f[1]], gid[f[2]]};
    std::sort(t.begin(), t.end());
    out.faces.insert(t);
    for (const VertId v : f) {
      const VertClass surface = p.mesh.vert_class[v] & (kSurface | kRidge | kCorner);
      out.corners[gid[v]] = {p.x(v), p.mesh.log_metric[v], surface};
    }
  }
  return out;
}

struct Pieces {
  std::vector<Part> parts;
  std::vector<IdVector<VertId, GlobalId>> gid;
};

/// A mesh cut into `count` pieces by planes through the middle.
Pieces cut(const MeshSpec& spec, int count, std::mt19937& random, double low, double high) {
  TetMesh whole = make_mesh(spec);
  set_metric(whole, random_smooth_metric(random, low, high, 1));
  const auto frame = random_frame(random);
  IdVector<TetId, int> label(whole.tet_slots());
  const Vec3 middle = whole.coords[VertId{static_cast<int>(whole.vert_slots() / 2)}];
  for (const TetId t : IdRange<TetId>(whole.tet_slots())) {
    Vec3 x;
    for (const VertId v : whole.tet2vert[t]) x += 0.25 * (whole.coords[v] - middle);
    label[t] = dot(x, frame[0]) > 0 ? 0 : count == 2 || dot(x, frame[1]) > 0 ? 1 : 2;
  }
  Pieces out;
  for (int b = 0; b < count; ++b) {
    Part p;
    IdVector<VertId, GlobalId> gid;
    p.mesh = cut_out(whole, label, b, gid);
    prepare(p);
    out.parts.push_back(std::move(p));
    out.gid.push_back(gid);
  }
  return out;
}

RC_GTEST_PROP(RefineInterface, GivesTheSameOnAllSides, ()) {
  MeshSpec spec;
  spec.two_regions = *rc::gen::arbitrary<bool>();
  spec.n = spec.two_regions ? *rc::gen::element(2, 4) : *rc::gen::inRange(1, 5);
  spec.shape = *rc::gen::element(Shape::kBox, Shape::kSkewed, Shape::kCylinder);
  spec.perturb = *rc::gen::element(0.0, 0.3);
  spec.seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  const int count = *rc::gen::element(2, 3);
  const bool keep = *rc::gen::element(false, false, true);
  Pieces pieces = cut(spec, count, random, 0.08, 0.6);
  std::multiset<Triple> faces;
  std::map<GlobalId, Corner> corners;
  for (std::size_t b = 0; b < pieces.parts.size(); ++b) {
    Part& p = pieces.parts[b];
    if (p.mesh.tet_slots() == 0) continue;
    const Snapshot before(p);
    const KeptVerts kept{.of_class = keep ? kSurface : VertClass{}};
    RC_ASSERT(refine_interface(p, pieces.gid[b], kept));
    RC_ASSERT(judge(p) == "");
    RC_ASSERT(differ(measure(before.mesh), measure(p.mesh), 1e-12) == "");
    for (const VertId v : IdRange<VertId>(before.mesh.vert_slots())) {  // nothing moves, nothing goes
      RC_ASSERT(p.mesh.is_live(v) && p.x(v) == before.mesh.coords[v]);
    }
    for (const auto& f : interface_faces(p.mesh)) {
      for (std::size_t i = 0; i < 3; ++i) {
        RC_ASSERT(p.mesh.has(f[i], kFrozen));
        const VertId v = f[i], w = f[(i + 1) % 3];
        const bool stays = kept.has(p.mesh, v) || kept.has(p.mesh, w);
        RC_ASSERT(stays || p.length(v, w) <= p.options.method.lengths.split_above * (1 + 1e-12));
      }
    }
    const Interface mine = interface_of(p, pieces.gid[b]);
    faces.insert(mine.faces.begin(), mine.faces.end());
    for (const auto& [gid, corner] : mine.corners) {
      const auto [at, fresh] = corners.emplace(gid, corner);
      RC_ASSERT(at->second.x == corner.x && at->second.log_m == corner.log_m);
      RC_ASSERT((at->second.surface & kCorner) == (corner.surface & kCorner));
    }
  }
  for (auto it = faces.begin(); it != faces.end(); it = faces.upper_bound(*it)) RC_ASSERT(faces.count(*it) == 2u);
}

}  // namespace
}  // namespace skein::test
