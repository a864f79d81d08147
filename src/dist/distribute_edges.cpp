// Feature edges and corners in distribute(): from the file and from the shape of the tagged faces.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "base/union_find.hpp"
#include "dist/distribute_steps.hpp"
#include "dist/feature_scan.hpp"
#include "dist/sharing.hpp"

namespace skein::distributing {
namespace {

double cos_degrees(double angle) noexcept { return std::cos(angle * std::numbers::pi / 180); }

/// An edge of one tagged face.
struct FaceEdge {
  GlobalId a, b;  ///< a < b
  Vec3 normal;    ///< unit
  Vec3 along;     ///< unit, from a to b
  std::int32_t patch;
  std::int32_t forward;  ///< 1 when the face, counter-clockwise, runs from a to b
};
/// A feature edge, as seen from one end.
struct FeatureEnd {
  GlobalId v, other;
  Vec3 along;  ///< unit, from v to other
  std::int32_t ref;
  FeatureClass edge_class;
  std::uint8_t given;  ///< by the file
  std::uint16_t unused;
  [[nodiscard]] bool is_implied() const noexcept { return any(edge_class & kImpliedEdge); }
};
/// A tagged face at vertex v.
struct FaceCorner {
  GlobalId v, b, c;
  std::int64_t hull;  ///< 1 for a face of the hull
};

template <class T>
struct Mail {
  std::vector<Rank> dest;
  std::vector<T> items;
  void add(Rank r, const T& item) {
    dest.push_back(r);
    items.push_back(item);
  }
  [[nodiscard]] std::vector<T> send(const Comm& comm) const { return exchange_items(comm, dest, items).items; }
};

/// The edges and corners of tagged faces, each to the rank that will see all of its kind: this one if one of its
/// vertices is not shared.
void send_surface(const FileSource& src, const Growing& g, std::vector<FaceEdge>& edges,
                  std::vector<FaceCorner>& corners) {
  const TetMesh& m = g.dist.mesh;
  const auto& gid = g.dist.vert2gid;
  const int ranks = src.comm.size();
  Mail<FaceEdge> edge_mail;
  Mail<FaceCorner> corner_mail;
  for (const FaceId f : g.speakers) {
    const auto v = m.verts(f);
    const Vec3 normal = normalized(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
    const int patch = tag_patch(m.tag(f));
    for (std::size_t k = 0; k < 3; ++k) {
      VertId a = v[k], b = v[(k + 1) % 3];
      corner_mail.add(g.many[a] != 0 ? meeting_rank(gid[a], ranks) : src.comm.rank(),
                      {gid[a], gid[b], gid[v[(k + 2) % 3]], is_hull(m.tag(f)) ? 1 : 0});
      const bool forward = gid[a] < gid[b];
      if (!forward) std::swap(a, b);
      edge_mail.add(g.many[a] != 0 && g.many[b] != 0 ? meeting_rank(gid[a], ranks) : src.comm.rank(),
                    {gid[a], gid[b], normal, normalized(m.coords[b] - m.coords[a]), patch, forward ? 1 : 0});
    }
  }
  edges = edge_mail.send(src.comm);
  corners = corner_mail.send(src.comm);
}

/// `feature`: as seen from its first end.
void add_both_ends(Mail<FeatureEnd>& mail, int ranks, FeatureEnd feature) {
  mail.add(meeting_rank(feature.v, ranks), feature);
  std::swap(feature.v, feature.other);
  feature.along = -1 * feature.along;
  mail.add(meeting_rank(feature.v, ranks), feature);
}

/// Ridges by the shape of the surface.
void find_ridges(const FileSource& src, std::vector<FaceEdge> edges, Mail<FeatureEnd>& mail) {
  const double flat = cos_degrees(src.options.ridge_angle);
  std::sort(edges.begin(), edges.end(), [](const FaceEdge& e, const FaceEdge& f) {
    return std::tie(e.a, e.b, e.patch) < std::tie(f.a, f.b, f.patch);
  });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i + 1;
    while (j < edges.size() && edges[j].a == edges[i].a && edges[j].b == edges[i].b) ++j;
    const FaceEdge &e = edges[i], &f = edges[j - 1];
    // Where both run the same way along the edge, one is seen from its back (internal faces have no outside).
    const double turn = e.forward != f.forward ? 1 : -1;
    if (j - i != 2 || e.patch != f.patch || turn * dot(e.normal, f.normal) < flat)
      add_both_ends(mail, src.comm.size(), {e.a, e.b, e.along, 0, kRidgeEdge, 0, 0});
    i = j;
  }
}

/// The edges of the file; their directions from the owners of the vertices.
void add_given_edges(const FileSource& src, Mail<FeatureEnd>& mail) {
  const auto& list = src.file.edges;
  std::vector<GlobalId> ends;
  std::vector<Rank> dest;
  for (const auto& e : list.verts) {
    for (const GlobalId v : e) {
      ends.push_back(v);
      dest.push_back(src.vert_blocks.owner(num(v)));
    }
  }
  const Inquiry<GlobalId> inquiry(src.comm, dest, ends);
  std::vector<Vec3> answers;
  for (const GlobalId v : inquiry.asked().items) answers.push_back(src.file.coords[num(v) - src.file.first_vert]);
  const auto x = inquiry.answer(answers);
  for (std::size_t i = 0; i < list.verts.size(); ++i) {
    const auto [a, b] = list.verts[i];
    if (a == b) continue;
    add_both_ends(mail, src.comm.size(),
                  {a, b, normalized(x[2 * i + 1] - x[2 * i]), list.ref[i], src.edge_class[i], 1, 0});
  }
}

/// The edges of required triangles and tetrahedra. Whoever has such an edge must know that it is not to be split, also
/// without the triangle or tetrahedron.
void add_implied_edges(const FileSource& src, const Growing& g, Mail<FeatureEnd>& mail) {
  const TetMesh& m = g.dist.mesh;
  const auto& gid = g.dist.vert2gid;
  const auto add = [&](VertId a, VertId b) {
    add_both_ends(mail, src.comm.size(), {gid[a], gid[b], {}, 0, kRequiredEdge | kImpliedEdge, 0, 0});
  };
  for (const FaceId f : g.speakers) {
    if ((m.tag(f) & kRequiredFace) == 0) continue;
    const auto v = m.verts(f);
    for (std::size_t k = 0; k < 3; ++k) add(v[k], v[(k + 1) % 3]);
  }
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (!m.has(t, kRequiredTet)) continue;
    for (std::size_t e = 0; e < kEdgeVerts.size(); ++e) {
      const auto [a, b] = m.edge_verts(t, e);
      add(a, b);
    }
  }
}

/// The features at each vertex that meets here, each edge once, ascending by (v, other).
std::vector<FeatureEnd> merge_ends(std::vector<FeatureEnd> ends) {
  std::sort(ends.begin(), ends.end(), [](const FeatureEnd& e, const FeatureEnd& f) {
    return std::tuple(e.v, e.other, e.is_implied(), -e.given, e.ref, e.edge_class) <
           std::tuple(f.v, f.other, f.is_implied(), -f.given, f.ref, f.edge_class);
  });
  std::vector<FeatureEnd> out;
  for (const auto& e : ends) {
    if (!out.empty() && out.back().v == e.v && out.back().other == e.other) {
      out.back().edge_class |= e.edge_class & ~kImpliedEdge;
    } else {
      out.push_back(e);
    }
  }
  return out;
}

enum class RimVert : std::int32_t {};  ///< place in the list of vertices round a vertex

/// Counts the fans of faces round one vertex.
class FanCounter {
 public:
  [[nodiscard]] std::size_t count(std::span<const FaceCorner> corners) {
    rim_.clear();
    for (const FaceCorner& c : corners) {
      rim_.push_back(c.b);
      rim_.push_back(c.c);
    }
    std::sort(rim_.begin(), rim_.end());
    rim_.erase(std::unique(rim_.begin(), rim_.end()), rim_.end());
    together_.reset(rim_.size());
    std::size_t fans = rim_.size();
    for (const FaceCorner& c : corners) fans -= together_.join(place(c.b), place(c.c)) ? 1 : 0;
    return fans;
  }

 private:
  [[nodiscard]] RimVert place(GlobalId g) const {
    return to_id<RimVert>(std::lower_bound(rim_.begin(), rim_.end(), g) - rim_.begin());
  }
  std::vector<GlobalId> rim_;
  UnionFind<RimVert> together_{0};
};

/// A vertex whose tagged faces are more than one fan.
struct SplitFan {
  GlobalId v;
  VertClass flags;
};

/// These vertices, ascending, each once: corners, and kContact where the faces of the hull are more than one fan.
std::vector<SplitFan> split_fans(std::vector<FaceCorner> corners) {
  std::sort(corners.begin(), corners.end(), [](const FaceCorner& a, const FaceCorner& b) {
    return std::tie(a.v, b.hull, a.b, a.c) < std::tie(b.v, a.hull, b.b, b.c);  // those of the hull first
  });
  std::vector<SplitFan> out;
  FanCounter fans;
  for (std::size_t i = 0; i < corners.size();) {
    std::size_t j = i, hull = i;
    for (; j < corners.size() && corners[j].v == corners[i].v; ++j) hull += corners[j].hull != 0 ? 1 : 0;
    const std::span all(corners.data() + i, j - i), of_hull(corners.data() + i, hull - i);
    const std::size_t hull_fans = fans.count(of_hull);
    if (hull_fans > 1) {
      out.push_back({corners[i].v, kCorner | kContact});
    } else if (all.size() > of_hull.size() && fans.count(all) > 1) {
      out.push_back({corners[i].v, kCorner});
    }
    i = j;
  }
  return out;
}

/// kRidge and kCorner of a vertex by the features at it.
VertClass flags_by_features(std::span<const FeatureEnd> at, double straight) noexcept {
  if (at.empty()) return {};
  std::array<const FeatureEnd*, 2> two{};
  std::size_t n = 0;
  for (const FeatureEnd& e : at) {
    if (e.is_implied()) continue;
    if (n < 2) two[n] = &e;
    ++n;
  }
  if (n == 0) return kRidge;
  const bool corner = n != 2 || two[0]->ref != two[1]->ref || two[0]->edge_class != two[1]->edge_class ||
                      dot(two[0]->along, two[1]->along) > -straight;
  return corner ? kRidge | kCorner : kRidge;
}

std::span<const FeatureEnd> features_at(const std::vector<FeatureEnd>& ends, GlobalId v) {
  const auto less = [](const FeatureEnd& e, GlobalId g) { return e.v < g; };
  const auto first = std::lower_bound(ends.begin(), ends.end(), v, less);
  auto last = first;
  while (last != ends.end() && last->v == v) ++last;
  return {first, last};
}

struct Feature {
  GlobalId a, b;
  std::int32_t ref;
  FeatureClass edge_class;
  std::array<std::uint8_t, 3> unused;
};

/// Asks for the features at all vertices that may have some; sets the vertex flags. Gives the features at them.
std::vector<Feature> ask_features(const FileSource& src, Growing& g, const std::vector<FeatureEnd>& ends) {
  TetMesh& m = g.dist.mesh;
  std::vector<GlobalId> questions;
  std::vector<VertId> verts;
  std::vector<Rank> dest;
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    if (!m.has(v, kSurface | kRidge)) continue;
    verts.push_back(v);
    questions.push_back(g.dist.vert2gid[v]);
    dest.push_back(meeting_rank(g.dist.vert2gid[v], src.comm.size()));
  }
  const Inquiry<GlobalId> inquiry(src.comm, dest, questions);
  const double straight = cos_degrees(src.options.corner_angle);
  const auto& asked = inquiry.asked();
  std::vector<VertClass> flags;
  Mail<Feature> mail;
  for (std::size_t b = 0; b < asked.blocks(); ++b) {
    for (const GlobalId v : asked.block(b)) {
      const auto at = features_at(ends, v);
      flags.push_back(flags_by_features(at, straight));
      for (const auto& e : at) {
        if (e.v < e.other) mail.add(asked.rank[b], {e.v, e.other, e.ref, e.edge_class, {}});
      }
    }
  }
  const auto answer = inquiry.answer(flags);
  for (std::size_t i = 0; i < verts.size(); ++i)
    m.vert_class[verts[i]] = (m.vert_class[verts[i]] & ~kRidge) | answer[i];
  return mail.send(src.comm);
}

/// Keeps the features that are edges of tetrahedra here.
void keep_local_features(Growing& g, const std::vector<Feature>& features) {
  TetMesh& m = g.dist.mesh;
  for (const auto& f : features) {
    const VertId a = g.gid2vert.find(f.a), b = g.gid2vert.find(f.b);
    if (a != kNoVert && b != kNoVert) m.features.insert({a, b, f.ref, f.edge_class});
  }
  std::vector<char> used(m.features.size(), 0);
  for_each_feature(m, [&](TetId, std::uint32_t edge) { used[edge] = 1; });
  FeatureEdges kept;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const FeatureEdge& e = m.features.list()[i];
    if (used[i] != 0) kept.insert(e);
  }
  m.features = std::move(kept);
}

/// Features that no rank has kept.
std::int64_t count_lost(const FileSource& src, const Growing& g, const std::vector<FeatureEnd>& ends) {
  struct Pair {
    GlobalId a, b;
    auto operator<=>(const Pair&) const = default;
  };
  Mail<Pair> mail;
  for (const auto& e : g.dist.mesh.features.list()) {
    const auto [a, b] = std::minmax(g.dist.vert2gid[e.a], g.dist.vert2gid[e.b]);
    mail.add(meeting_rank(a, src.comm.size()), {a, b});
  }
  auto kept = mail.send(src.comm);
  std::sort(kept.begin(), kept.end());
  std::int64_t lost = 0;
  for (const auto& e : ends) {
    if (e.v < e.other && !std::binary_search(kept.begin(), kept.end(), Pair{e.v, e.other})) ++lost;
  }
  return src.comm.sum(lost);
}

}  // namespace

void find_features(const FileSource& src, Growing& g, DistributeReport& report) {
  std::vector<FaceEdge> edges;
  std::vector<FaceCorner> corners;
  send_surface(src, g, edges, corners);
  Mail<FeatureEnd> mail;
  find_ridges(src, std::move(edges), mail);
  add_given_edges(src, mail);
  add_implied_edges(src, g, mail);
  const auto ends = merge_ends(mail.send(src.comm));
  keep_local_features(g, ask_features(src, g, ends));
  // The fans at an unshared vertex have met on its rank; those at a shared one on its meeting rank.
  const auto fans = split_fans(std::move(corners));
  report.lost_edges = count_lost(src, g, ends);
  std::int64_t found = 0;
  for (const auto& e : ends) found += e.v < e.other && e.given == 0 && !e.is_implied() ? 1 : 0;
  report.found_ridges = src.comm.sum(found);
  std::vector<GlobalId> questions;
  std::vector<VertId> verts;
  std::vector<Rank> dest;
  for (const VertId v : g.dist.sharing.vert) {
    verts.push_back(v);
    questions.push_back(g.dist.vert2gid[v]);
    dest.push_back(meeting_rank(g.dist.vert2gid[v], src.comm.size()));
  }
  const Inquiry<GlobalId> inquiry(src.comm, dest, questions);
  std::vector<VertClass> flags;
  for (const GlobalId v : inquiry.asked().items) {
    const auto at =
        std::lower_bound(fans.begin(), fans.end(), v, [](const SplitFan& s, GlobalId w) { return s.v < w; });
    flags.push_back(at != fans.end() && at->v == v ? at->flags : VertClass{});
  }
  const auto answer = inquiry.answer(flags);
  for (std::size_t i = 0; i < verts.size(); ++i) g.dist.mesh.vert_class[verts[i]] |= answer[i];
  for (const SplitFan& fan : fans) {
    const VertId here = g.gid2vert.find(fan.v);
    if (here != kNoVert) g.dist.mesh.vert_class[here] |= fan.flags;
  }
  classify_features(src.comm, g);
}

}  // namespace skein::distributing
