// Euler characteristic and pieces of sets of boundary entities.
#include "report/shapes.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <tuple>
#include <utility>

#include "base/union_find.hpp"
#include "comm/inquiry.hpp"
#include "dist/rendezvous.hpp"

namespace skein {
namespace {

/// A set of faces and edges: a patch, the hull, the features.
using Group = std::uint32_t;

/// An edge of a face or a feature edge, as one of a group.
struct EdgeUse {
  std::uint64_t ends;  ///< both vertices, see ends_of()
  Group group;
  std::uint32_t face;  ///< place in the list of normals; 0: no face
};
constexpr std::uint64_t ends_of(VertId a, VertId b) noexcept { return std::uint64_t{idx(a)} << 32 | idx(b); }
constexpr VertId first_end(const EdgeUse& u) noexcept { return to_id<VertId>(u.ends >> 32); }
constexpr VertId second_end(const EdgeUse& u) noexcept { return to_id<VertId>(u.ends & 0xffffffffU); }

struct SharedEdge {
  Group group;
  GlobalId a, b;
  Vec3 normal;
};
/// A vertex of a group. Items of a group that edges connect hang together.
struct Item {
  Group group;
  VertId v;
  friend bool operator==(const Item&, const Item&) = default;
};
/// What a rank tells of a shared item: its piece there.
struct Labelled {
  Group group;
  GlobalId gid;
  std::int64_t label;
};
/// Two labels of one piece.
struct Link {
  std::int64_t a, b;
  std::int64_t group;
  friend auto operator<=>(const Link&, const Link&) = default;
};

template <class T>
void once(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

class Finder {
 public:
  Finder(const Comm& comm, const DistMesh& dist)
      : comm_(comm),
        dist_(dist),
        patches_(static_cast<Group>(dist.mesh.patch_ref.size())),
        shared_(dist.mesh.vert_slots(), 0),
        euler_(patches_ + 2, 0),
        pieces_(patches_ + 2, 0),
        folded_(patches_, 0),
        last_place_(dist.mesh.vert_slots(), 0) {
    for (const VertId v : dist.sharing.vert) shared_[v] = 1;
  }
  void take(FaceId f);
  void take(const FeatureEdge& e) { take(patches_ + 1, e.a, e.b, 0); }
  ShapesFound result();

 private:
  void take(Group group, VertId a, VertId b, std::uint32_t face) {
    if (dist_.vert2gid[b] < dist_.vert2gid[a]) std::swap(a, b);
    uses_.push_back({ends_of(a, b), group, face});
  }
  template <class Use, class Key, class Normal>
  void count_edges(std::vector<Use>& uses, Key key, Normal normal);
  void count_edges();
  VertId place(Group group, VertId v);
  void count_pieces();
  void tell_labels(UnionFind<VertId>& sets);
  void join_labels(std::vector<Labelled> told);

  const Comm& comm_;
  const DistMesh& dist_;
  Group patches_;
  IdVector<VertId, char> shared_;
  std::vector<std::int64_t> euler_, pieces_;
  std::vector<double> folded_;
  std::vector<EdgeUse> uses_;
  std::vector<Vec3> normals_{{}};
  std::vector<Item> items_;
  IdVector<VertId, std::uint32_t> last_place_;  ///< in items_, of the group that had the vertex last
};

void Finder::take(FaceId f) {
  const TetMesh& m = dist_.mesh;
  const auto v = m.verts(f);
  const FaceTag tag = m.tag(f);
  const Vec3 n = normalized(cross(m.coords[v[1]] - m.coords[v[0]], m.coords[v[2]] - m.coords[v[0]]));
  const auto patch = static_cast<Group>(tag_patch(tag));
  const auto face = static_cast<std::uint32_t>(normals_.size());
  normals_.push_back(n);
  ++euler_[patch];
  if (is_hull(tag)) ++euler_[patches_];
  for (std::size_t k = 0; k < 3; ++k) {
    take(patch, v[k], v[(k + 1) % 3], face);
    if (is_hull(tag)) take(patches_, v[k], v[(k + 1) % 3], face);
  }
}

/// Edges that are all here: each once, and the fold at those with two faces of the patch. More faces, or one, make a
/// feature edge, and at those the patch may fold.
template <class Use, class Key, class Normal>
void Finder::count_edges(std::vector<Use>& uses, Key key, Normal normal) {
  std::sort(uses.begin(), uses.end(), [&](const Use& u, const Use& w) { return key(u) < key(w); });
  for (std::size_t i = 0, j = 0; i < uses.size(); i = j) {
    for (j = i; j < uses.size() && key(uses[j]) == key(uses[i]);) ++j;
    --euler_[uses[i].group];
    if (j - i != 2 || uses[i].group >= patches_) continue;
    if (norm(cross(normal(uses[i]), normal(uses[i + 1]))) > kStraight) folded_[uses[i].group] = 1;
  }
}

void Finder::count_edges() {
  std::vector<Rank> dest;
  std::vector<SharedEdge> send;
  std::erase_if(uses_, [&](const EdgeUse& u) {
    const VertId a = first_end(u), b = second_end(u);
    if (shared_[a] == 0 || shared_[b] == 0) return false;
    send.push_back({u.group, dist_.vert2gid[a], dist_.vert2gid[b], normals_[u.face]});
    dest.push_back(meeting_rank(dist_.vert2gid[a], comm_.size()));
    return true;
  });
  count_edges(
      uses_, [](const EdgeUse& u) { return std::pair(u.group, u.ends); },
      [&](const EdgeUse& u) { return normals_[u.face]; });
  auto met = exchange_items(comm_, dest, send).items;
  count_edges(
      met, [](const SharedEdge& u) { return std::tuple(u.group, u.a, u.b); },
      [](const SharedEdge& u) { return u.normal; });
}

/// The place of an item, a new one where it is not there. @pre the groups are asked for one after the other
VertId Finder::place(Group group, VertId v) {
  std::uint32_t& last = last_place_[v];
  const Item item{group, v};
  if (last >= items_.size() || items_[last] != item) {
    last = static_cast<std::uint32_t>(items_.size());
    items_.push_back(item);
  }
  return to_id<VertId>(last);
}

void Finder::count_pieces() {
  std::vector<std::size_t> begin(euler_.size() + 1, 0);
  for (const EdgeUse& u : uses_) ++begin[u.group + 1];
  for (std::size_t g = 1; g < begin.size(); ++g) begin[g] += begin[g - 1];
  std::vector<EdgeUse> by_group(uses_.size());
  for (const EdgeUse& u : uses_) by_group[begin[u.group]++] = u;
  uses_ = std::move(by_group);
  std::vector<std::array<VertId, 2>> joints;
  joints.reserve(uses_.size());
  for (const EdgeUse& u : uses_) {
    const VertId a = place(u.group, first_end(u));
    joints.push_back({a, place(u.group, second_end(u))});
  }
  UnionFind<VertId> sets(items_.size());
  for (const auto& [a, b] : joints) sets.join(a, b);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const VertId me = to_id<VertId>(i);
    if (sets.root(me) == me) ++pieces_[items_[i].group];
    if (shared_[items_[i].v] == 0) ++euler_[items_[i].group];
  }
  tell_labels(sets);
}

void Finder::tell_labels(UnionFind<VertId>& sets) {
  const auto first = comm_.exclusive_sum(static_cast<std::int64_t>(items_.size()));
  std::vector<Rank> dest;
  std::vector<Labelled> send;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (shared_[items_[i].v] == 0) continue;
    const GlobalId g = dist_.vert2gid[items_[i].v];
    send.push_back({items_[i].group, g, first + static_cast<std::int64_t>(idx(sets.root(to_id<VertId>(i))))});
    dest.push_back(meeting_rank(g, comm_.size()));
  }
  join_labels(exchange_items(comm_, dest, send).items);
}

void Finder::join_labels(std::vector<Labelled> told) {
  const auto key = [](const Labelled& l) { return std::tie(l.group, l.gid); };
  std::sort(told.begin(), told.end(), [&](const Labelled& l, const Labelled& o) { return key(l) < key(o); });
  std::vector<Link> links;
  for (std::size_t i = 0; i < told.size(); ++i) {
    if (i == 0 || key(told[i]) != key(told[i - 1])) {
      ++euler_[told[i].group];
      continue;
    }
    const auto [a, b] = std::minmax(told[i].label, told[i - 1].label);
    links.push_back({a, b, told[i].group});
  }
  once(links);
  links = comm_.all_gather(links);
  std::vector<std::int64_t> labels;
  for (const Link& l : links) labels.insert(labels.end(), {l.a, l.b});
  once(labels);
  const auto number = [&](std::int64_t label) {
    return to_id<VertId>(std::lower_bound(labels.begin(), labels.end(), label) - labels.begin());
  };
  UnionFind<VertId> sets(labels.size());
  if (!comm_.is_root()) return;  // one rank takes them off
  for (const Link& l : links) {
    if (sets.join(number(l.a), number(l.b))) --pieces_[static_cast<std::size_t>(l.group)];
  }
}

ShapesFound Finder::result() {
  count_pieces();
  count_edges();
  comm_.reduce(std::span<std::int64_t>(euler_), Op::kSum);
  comm_.reduce(std::span<std::int64_t>(pieces_), Op::kSum);
  comm_.reduce(std::span<double>(folded_), Op::kMax);
  ShapesFound out;
  for (std::size_t g = 0; g < euler_.size(); ++g) out.shapes.push_back({euler_[g], pieces_[g]});
  out.folded = std::move(folded_);
  return out;
}

}  // namespace

ShapesFound find_shapes(const Comm& comm, const DistMesh& dist, const std::vector<FaceId>& faces,
                        const std::vector<FeatureEdge>& edges) {
  Finder finder(comm, dist);
  for (const FaceId f : faces) finder.take(f);
  for (const FeatureEdge& e : edges) finder.take(e);
  return finder.result();
}

}  // namespace skein
