// Every operator on random meshes in random metrics: a random sequence of operations, each judged from outside.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <set>

#include "kernel/operators/collapse.hpp"
#include "kernel/operators/insert.hpp"
#include "kernel/operators/smooth.hpp"
#include "kernel/operators/swap.hpp"
#include "mesh/check.hpp"
#include "tests/kernel/judge.hpp"
#include "tests/kernel/metrics.hpp"

namespace skein::test {
namespace {

/// What a case starts from.
struct Setting {
  MeshSpec mesh;
  bool cut = false;  ///< half of the mesh is another part: its faces are the interface
  bool surface = true;
  bool least = false, anchored = false;  ///< QualityMeasure::kLeast; with anchors of the metric
  unsigned seed = 1;
};

Setting any_setting(Shape shape) {
  Setting s;
  s.mesh.shape = shape;
  s.mesh.two_regions = *rc::gen::arbitrary<bool>();
  s.mesh.n = s.mesh.two_regions ? *rc::gen::element(2, 4) : *rc::gen::inRange(2, 5);
  s.mesh.required = *rc::gen::element(false, false, true);
  s.mesh.perturb = *rc::gen::element(0.0, 0.15, 0.3);
  s.mesh.seed = *rc::gen::inRange(0u, 10000u);
  s.cut = *rc::gen::arbitrary<bool>();
  s.surface = *rc::gen::element(true, true, true, false);
  s.least = *rc::gen::element(false, false, true);
  s.anchored = *rc::gen::arbitrary<bool>();
  s.seed = *rc::gen::inRange(0u, 1000000u);
  return s;
}

Part make_part(const Setting& s, std::mt19937& random) {
  Part part;
  part.mesh = make_mesh(s.mesh);
  if (s.cut) {
    IdVector<TetId, int> label(part.mesh.tet_slots());
    const Vec3 normal = random_frame(random)[0],
               middle = part.mesh.coords[VertId{static_cast<int>(part.mesh.vert_slots() / 2)}];
    for (const TetId t : IdRange<TetId>(part.mesh.tet_slots())) {
      Vec3 x;
      for (const VertId v : part.mesh.tet2vert[t]) x += 0.25 * part.mesh.coords[v];
      label[t] = dot(x - middle, normal) > 0 ? 1 : 0;
    }
    IdVector<VertId, GlobalId> gid;
    part.mesh = cut_out(part.mesh, label, 0, gid);
  }
  set_metric(part.mesh, random_smooth_metric(random, 0.05, 1.0, 1.5));
  part.options.surface = s.surface ? SurfaceChange::kAllowed : SurfaceChange::kNone;
  part.quality_measure = s.least ? QualityMeasure::kLeast : QualityMeasure::kLargestMetric;
  if (s.anchored) {
    for (const VertId v : IdRange<VertId>(part.mesh.vert_slots()))
      part.mesh.anchor.push_back({part.x(v), part.mesh.log_metric[v]});
  }
  prepare(part);
  return part;
}

constexpr double kNoSurface = 0;

double quality_cubed_by_largest(Vec3 x0, Vec3 x1, Vec3 x2, Vec3 x3, const VertMetric& m0, const VertMetric& m1,
                                const VertMetric& m2, const VertMetric& m3) {
  return quality_cubed(x0, x1, x2, x3, m0, m1, m2, m3);
}

/// A part with its operators; each is applied and judged.
class Bench {
 public:
  explicit Bench(const Setting& s)
      : random_(s.seed),
        part_(make_part(s, random_)),
        flat_(is_flat_sided(s.mesh.shape)),
        cavity_(part_),
        insert_(part_, cavity_),
        collapse_(part_, cavity_),
        swap_(part_, cavity_),
        smooth_(part_) {}

  /// Applies one operator at random. Empty, or what is wrong.
  std::string step() {
    if (count_tets(part_.mesh) == 0) return {};
    const TetId t = any_tet();
    const auto tv = part_.mesh.tet2vert[t];
    const auto& e = kEdgeVerts[random_() % 6];
    VertId a = tv[e[0]], b = tv[e[1]];
    if (random_() % 2 == 0) std::swap(a, b);
    switch (random_() % 13) {
      case 0:
      case 1:
        return on_edge(t, a, b);
      case 2:
        return inside(t);
      case 3:
      case 4:
        return collapse(t, a, b);
      case 5:
        return edge_swap(t, a, b);
      case 6:
        return face_swap(make_face(t, static_cast<int>(random_() % 4)));
      case 7:
        return relax(t, a, b, static_cast<int>(random_() % 3));
      case 8:
        return along_axes(a);
      case 9:
      case 10:
        return reduce_sum(t, a, b, static_cast<int>(random_() % 3));
      case 11:
        return collapse_to_improve(t, a, b);
      default:
        return move(a);
    }
  }
  [[nodiscard]] const Part& part() const { return part_; }
  int done = 0, surface_done = 0;

 private:
  double any(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  TetId any_tet() {
    for (;;) {
      const TetId t{static_cast<int>(random_() % part_.mesh.tet_slots())};
      if (part_.mesh.is_live(t)) return t;
    }
  }

  /// Tells what operation it was when something is wrong.
  std::string say(const std::string& name, const std::string& fault) {
    return fault.empty() ? "" : fmt::format("{} ({} done before): {}", name, done, fault);
  }
  /// What holds for all operators. `new_shape`: the operator may leave curved facets a little.
  std::string verdict(const Snapshot& before, bool did, bool new_shape, VertId moved = kNoVert) {
    if (!did) return differ(before, part_);
    ++done;
    return judge(before, part_, flat_ || !new_shape ? 1e-12 : kNoSurface, moved);
  }
  /// Shortest edge at p.
  double nearest(VertId p) {
    double l = 1e300;
    for (const TetId t : IdRange<TetId>(part_.mesh.tet_slots())) {
      if (!part_.mesh.is_live(t) || !has_vertex(part_.mesh.tet2vert[t], p)) continue;
      for (const VertId v : part_.mesh.tet2vert[t]) {
        if (v != p) l = std::min(l, part_.length(p, v));
      }
    }
    return l;
  }
  /// The one vertex that `after` has more.
  VertId newcomer(const Snapshot& before) {
    for (const VertId v : IdRange<VertId>(part_.mesh.vert_slots())) {
      if (part_.mesh.is_live(v) && !(idx(v) < before.mesh.vert_slots() && before.mesh.is_live(v))) return v;
    }
    return kNoVert;
  }
  std::string inserted(const Snapshot& before, double exclusion, double seed_min) {
    const Change c = change(before, part_);
    const VertId p = newcomer(before);
    if (p == kNoVert) return "no new vertex";
    if (nearest(p) < exclusion) return "the new vertex is too close to another";
    if (!(c.new_min > std::max(1e-15, 0.999999 * std::min(0.008, 0.125 * seed_min)))) {
      return fmt::format("quality {} below the floor, seeds had {}", std::cbrt(c.new_min), std::cbrt(seed_min));
    }
    for (const TetId t : c.fresh) {
      if (!has_vertex(part_.mesh.tet2vert[t], p)) return "a new tetrahedron lacks the new vertex";
    }
    return {};
  }

  std::string on_edge(TetId t, VertId a, VertId b) {
    const Snapshot before(part_);
    const FeatureEdge* f = part_.mesh.features.find(a, b);
    const FeatureEdge feature = f == nullptr ? FeatureEdge{} : *f;
    double seed_min = 1;
    for (const TetId s : IdRange<TetId>(part_.mesh.tet_slots())) {
      const auto& tv = part_.mesh.tet2vert[s];
      if (part_.mesh.is_live(s) && has_vertex(tv, a) && has_vertex(tv, b))
        seed_min = std::min<double>(seed_min, part_.q3[s]);
    }
    const bool did = insert_.on_edge(t, a, b, any(0.1, 0.9)) == InsertResult::kDone;
    if (auto fault = verdict(before, did, false); !fault.empty()) return say("on_edge", fault);
    if (!did) return {};
    const VertId p = newcomer(before);
    if (f != nullptr && (part_.mesh.features.find(a, p) == nullptr || part_.mesh.features.find(p, b) == nullptr ||
                         part_.mesh.features.find(a, p)->ref != feature.ref)) {
      return say("on_edge", "a feature edge is not split as such");
    }
    return say("on_edge", inserted(before, part_.options.method.lengths.closest_new, seed_min));
  }

  std::string inside(TetId t) {
    const Snapshot before(part_);
    std::array<double, 4> w{any(0.1, 1), any(0.1, 1), any(0.1, 1), any(0.1, 1)};
    const double sum = w[0] + w[1] + w[2] + w[3];
    for (auto& x : w) x /= sum;
    const double exclusion = any(0, 0.8), seed_min = part_.q3[t];
    const bool did = insert_.inside(t, w, exclusion) == InsertResult::kDone;
    if (auto fault = verdict(before, did, false); !fault.empty()) return say("inside", fault);
    return did ? say("inside", inserted(before, exclusion, seed_min)) : "";
  }

  std::string collapse(TetId t, VertId v, VertId u) {
    const Snapshot before(part_);
    const double max_length = any(1, 6), floor_q3 = any(0, 0.03);
    const bool on_surface = part_.mesh.has(v, kSurface);
    const bool did = collapse_.collapse(v, u, t, max_length, KeepFloor{floor_q3, 0.5});
    if (auto fault = verdict(before, did, on_surface); !fault.empty()) return say("collapse", fault);
    if (!did) return {};
    surface_done += on_surface;
    if (part_.mesh.is_live(v)) return "collapse: the vertex is still there";
    const Change c = change(before, part_);
    if (!(c.new_min > std::min(floor_q3, 0.5 * c.old_min) * 0.999999))
      return say("collapse", "quality below the floor");
    // New are the edges from u to what was no neighbour of it.
    for (const TetId fresh : c.fresh) {
      for (const VertId w : part_.mesh.tet2vert[fresh]) {
        if (w == u || part_.length(u, w) <= max_length) continue;
        bool neighbour = false;
        for (const auto& tv : before.mesh.tet2vert) neighbour = neighbour || (has_vertex(tv, u) && has_vertex(tv, w));
        if (!neighbour) return say("collapse", "a new edge is too long");
      }
    }
    return {};
  }

  std::string collapse_to_improve(TetId t, VertId v, VertId u) {
    const Snapshot before(part_);
    const double gain = any(1, 2);
    const bool on_surface = part_.mesh.has(v, kSurface);
    const bool did = collapse_.collapse(v, u, t, any(1, 6), RaiseWorst{gain});
    if (auto fault = verdict(before, did, on_surface); !fault.empty()) return say("collapse to improve", fault);
    if (!did) return {};
    surface_done += on_surface;
    if (part_.mesh.is_live(v)) return "collapse to improve: the vertex is still there";
    return swapped("collapse to improve", before, gain);
  }

  std::string swapped(const char* name, const Snapshot& before, double gain) {
    const Change c = change(before, part_);
    // old_min_q3 is known in single precision
    if (!(c.new_min > gain * c.old_min * (1 - 1e-6)) || !(c.new_min > c.old_min)) {
      return say(name, fmt::format("worst quality from {} to {}", std::cbrt(c.old_min), std::cbrt(c.new_min)));
    }
    return {};
  }
  std::string edge_swap(TetId t, VertId a, VertId b) {
    const Snapshot before(part_);
    const bool did = swap_.edge(t, a, b, RaiseWorst{1.05});
    bool on_surface = false;
    if (did) {
      for (const TetId s : change(before, part_).gone) {
        const auto& tags = before.mesh.face_tag[s];
        for (const FaceTag tag : tags) on_surface = on_surface || tag != 0;
      }
    }
    if (auto fault = verdict(before, did, on_surface); !fault.empty()) return say("edge swap", fault);
    if (!did) return {};
    surface_done += on_surface;
    for (const TetId s : IdRange<TetId>(part_.mesh.tet_slots())) {
      const auto& tv = part_.mesh.tet2vert[s];
      if (part_.mesh.is_live(s) && has_vertex(tv, a) && has_vertex(tv, b)) return "edge swap: the edge is still there";
    }
    return swapped("edge swap", before, 1.05);
  }
  std::string face_swap(FaceId f) {
    const Snapshot before(part_);
    const bool did = swap_.face(f, RaiseWorst{1.05});
    if (auto fault = verdict(before, did, false); !fault.empty()) return say("face swap", fault);
    return did ? swapped("face swap", before, 1.05) : "";
  }

  std::string move(VertId v) {
    const Snapshot before(part_);
    const bool did = smooth_.move(v, SmoothBall{});
    // A straight ridge may have curved patches at its sides, whose facets then turn.
    if (auto fault = verdict(before, did, part_.mesh.has(v, kRidge), v); !fault.empty()) return say("move", fault);
    if (!did) return {};
    surface_done += part_.mesh.has(v, kSurface);
    const Change c = change(before, part_, v);
    if (part_.mesh.tet2vert != before.mesh.tet2vert) return say("move", "the connections have changed");
    if (!(c.new_min >= std::min(c.old_min, 0.125) * (1 - 1e-6))) {
      return say("move", fmt::format("worst quality from {} to {}", std::cbrt(c.old_min), std::cbrt(c.new_min)));
    }
    return {};
  }

  struct Strain {
    double edges = 0, shape = 0;  ///< summed over edges; 1/Q^3 over elements
  };
  static Strain strain_of(const TetMesh& mesh, QualityMeasure quality) {
    Strain out;
    std::set<std::pair<VertId, VertId>> edges;
    const auto& m = mesh.metric;
    const auto& x = mesh.coords;
    for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
      if (!mesh.is_live(t)) continue;
      const auto& v = mesh.tet2vert[t];
      const auto measure = quality == QualityMeasure::kLeast ? least_quality_cubed : quality_cubed_by_largest;
      out.shape += 1 / measure(x[v[0]], x[v[1]], x[v[2]], x[v[3]], m[v[0]], m[v[1]], m[v[2]], m[v[3]]);
      for (const auto& e : kEdgeVerts) {
        edges.insert(std::minmax(v[e[0]], v[e[1]]));
      }
    }
    for (const auto& [a, b] : edges) out.edges += strain(edge_length(m[a].m, m[b].m, x[b] - x[a]));
    return out;
  }
  /// An operator that may make elements worse down to a floor for the good of a sum: did(max_length, floor_q3) is it;
  /// moved: its vertex if it moves one; fault_of_sum(before, change) is empty if the sum is less. `slack`: of the
  /// floor.
  template <class Did, class IsFault>
  std::string lessen(const char* name, VertId a, VertId moved, double slack, Did&& did, IsFault&& fault_of_sum) {
    const Snapshot before(part_);
    const double floor_q3 = any(0, 0.3), max_length = any(1, 3);
    const bool on_surface = part_.mesh.has(a, kSurface), done = did(max_length, floor_q3);
    if (auto fault = verdict(before, done, on_surface, moved); !fault.empty()) return say(name, fault);
    if (!done) return {};
    const Change c = change(before, part_, moved);
    if (!(c.new_min >= slack * std::min(c.old_min, floor_q3) * (1 - 1e-6))) return say(name, "below the floor");
    const std::string fault = fault_of_sum(before, c);
    return fault.empty() ? "" : say(name, fault);
  }
  /// One of the operators with the objective LowerStrain.
  std::string relax(TetId t, VertId a, VertId b, int which) {
    const auto did = [&](double max_length, double floor_q3) {
      return which == 0   ? collapse_.collapse(a, b, t, max_length, LowerStrain{floor_q3})
             : which == 1 ? swap_.edge(t, a, b, LowerStrain{floor_q3, 0.99, 0.95})
                          : smooth_.move(a, LowerStrain{floor_q3});
    };
    return lessen("relax", a, which == 2 ? a : kNoVert, 0.99, did, [&](const Snapshot& before, const Change&) {
      const Strain was = strain_of(before.mesh, before.quality_measure),
                   is = strain_of(part_.mesh, part_.quality_measure);
      const double shape = which == 2 ? 0.005 : 0;
      const bool less = is.edges + shape * is.shape < (was.edges + shape * was.shape) * (1 + 1e-4);
      return less ? "" : fmt::format("strain from {} to {} by operator {}", was.edges, is.edges, which);
    });
  }
  std::string along_axes(VertId v) {
    const Snapshot before(part_);
    const bool did = smooth_.move(v, RaiseWorst{1.01});
    if (auto fault = verdict(before, did, part_.mesh.has(v, kRidge), v); !fault.empty()) return say("axes", fault);
    if (!did) return {};
    const Change c = change(before, part_, v);
    return c.new_min > c.old_min ? "" : say("axes", "the worst element did not get better");
  }
  /// One of the operators that lessen the sum of Q^-6.
  std::string reduce_sum(TetId t, VertId a, VertId b, int which) {
    const auto did = [&](double max_length, double floor_q3) {
      return which == 0   ? collapse_.collapse(a, b, t, max_length, LowerSum{floor_q3, 0.99})
             : which == 1 ? swap_.edge(t, a, b, LowerSum{floor_q3, 0.995, 0.999})
                          : smooth_.move(a, LowerSum{floor_q3, 0.998});
    };
    return lessen("reduce_sum", a, which == 2 ? a : kNoVert, 0.999, did, [&](const Snapshot&, const Change& c) {
      const bool less = c.new_sum < c.old_sum;
      return less ? "" : fmt::format("from {} to {} by operator {}", c.old_sum, c.new_sum, which);
    });
  }

  std::mt19937 random_;
  Part part_;
  bool flat_;
  Cavity cavity_;
  Inserter insert_;
  Collapser collapse_;
  Swapper swap_;
  Smoother smooth_;
};

void run(Shape shape) {
  const Setting s = any_setting(shape);
  const int steps = *rc::gen::inRange(1, 400);
  RC_LOG() << fmt::format(
      "n {} regions {} required {} perturb {} mesh seed {} cut {} surface {} least {} anchored {} seed {} steps {}",
      s.mesh.n, s.mesh.two_regions, s.mesh.required, s.mesh.perturb, s.mesh.seed, s.cut, s.surface, s.least, s.anchored,
      s.seed, steps);
  Bench bench(s);
  RC_ASSERT(judge(bench.part()) == "");
  for (int i = 0; i < steps; ++i) RC_ASSERT(bench.step() == "");
  RC_CLASSIFY(bench.done > steps / 8, "many done");
  RC_CLASSIFY(bench.surface_done > 0, "surface changed");
}

RC_GTEST_PROP(Operators, KeepTheirPromisesOnTheBox, ()) { run(Shape::kBox); }
RC_GTEST_PROP(Operators, KeepTheirPromisesOnSkewedSides, ()) { run(Shape::kSkewed); }
RC_GTEST_PROP(Operators, KeepTheirPromisesOnTheCylinder, ()) { run(Shape::kCylinder); }
RC_GTEST_PROP(Operators, KeepTheirPromisesOnTheSphere, ()) { run(Shape::kSphere); }

}  // namespace
}  // namespace skein::test
