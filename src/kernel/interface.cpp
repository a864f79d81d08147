// Refinement of a part's interface by a rule that both sides follow without talking to each other.
#include "kernel/interface.hpp"

#include <algorithm>
#include <bit>
#include <queue>

#include "kernel/cavity.hpp"
#include "kernel/shell.hpp"

namespace skein {
namespace {

/// 62 bits from two ids; above all ids that are counted.
GlobalId hashed_id(GlobalId a, GlobalId b) noexcept {
  auto mix = [](std::uint64_t h) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    return h ^ (h >> 31);
  };
  const auto h =
      mix(mix(static_cast<std::uint64_t>(num(a)) + 0x9e3779b97f4a7c15ULL) ^ static_cast<std::uint64_t>(num(b)));
  return GlobalId{static_cast<std::int64_t>((h >> 2) | 1ULL << 61)};
}

/// What both sides compute must have the same bits, so it must not be inlined into different surroundings.
[[gnu::noinline]] double shared_length(const Part& p, VertId a, VertId b) noexcept { return p.length(a, b); }
[[gnu::noinline]] Vec3 shared_middle(Vec3 a, Vec3 b) noexcept {
  return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (a.z + b.z)};
}
[[gnu::noinline]] SymTensor shared_middle(const SymTensor& a, const SymTensor& b) noexcept { return 0.5 * (a + b); }

/// Edges to a kept vertex are split to this depth: over a long kept edge the splits would come nearer and nearer to it
/// without end.
constexpr int kDeepest = 3;

/// The vertex opposite an edge in an interface face, and a tetrahedron that has the face.
struct Third {
  VertId c;
  TetId tet;
  friend bool operator==(const Third&, const Third&) = default;
};

/// The faces at each interface edge: mostly two, four or more where parts touch in an edge only. Open addressing with
/// an entry for each edge of a face.
class EdgeFaces {
 public:
  void insert(VertId a, VertId b, Third third) {
    if (2 * (used_ + 1) > entries_.size()) rehash();
    std::size_t s = home(key(a, b));
    while (entries_[s].key != kFree) s = next(s);
    entries_[s] = {key(a, b), third};
    ++used_;
  }
  void erase(VertId a, VertId b, Third third) noexcept {
    const Key k = key(a, b);
    for (std::size_t s = home(k); entries_[s].key != kFree; s = next(s)) {
      if (entries_[s].key == k && entries_[s].third == third) entries_[s].key = kErased;
    }
  }
  /// Calls visit(third) for those at the edge.
  template <class Visit>
  void for_each(VertId a, VertId b, Visit&& visit) const {
    const Key k = key(a, b);
    for (std::size_t s = home(k); !entries_.empty() && entries_[s].key != kFree; s = next(s)) {
      if (entries_[s].key == k) visit(entries_[s].third);
    }
  }

 private:
  using Key = std::uint64_t;
  static constexpr Key kFree = ~Key{0}, kErased = kFree - 1;
  struct Entry {
    Key key = kFree;
    Third third{kNoVert, kNoTet};
  };
  static Key key(VertId a, VertId b) noexcept {
    if (b < a) std::swap(a, b);
    return static_cast<Key>(static_cast<std::uint32_t>(num(a))) << 32 | static_cast<std::uint32_t>(num(b));
  }
  [[nodiscard]] std::size_t home(Key k) const noexcept {
    return static_cast<std::size_t>((k ^ k >> 29) * 0x9e3779b97f4a7c15ULL >> 20) & (entries_.size() - 1);
  }
  [[nodiscard]] std::size_t next(std::size_t s) const noexcept { return (s + 1) & (entries_.size() - 1); }
  void rehash() {
    std::vector<Entry> old;
    old.swap(entries_);
    std::erase_if(old, [](const Entry& e) { return e.key >= kErased; });
    entries_.resize(std::bit_ceil(4 * old.size() + 64));
    used_ = old.size();
    for (const Entry& e : old) {
      std::size_t s = home(e.key);
      while (entries_[s].key != kFree) s = next(s);
      entries_[s] = e;
    }
  }

  std::vector<Entry> entries_;  ///< a power of two
  std::size_t used_ = 0;        ///< erased ones, too
};

class InterfaceRefiner {
 public:
  InterfaceRefiner(Part& part, IdVector<VertId, GlobalId>& gid, KeptVerts keep, double longest)
      : part_(part), gid_(gid), cavity_(part), keep_(keep), longest_(longest) {}

  bool run() {
    collect();
    while (!queue_.empty()) {
      const Entry e = queue_.top();
      queue_.pop();
      if (!split(e.a, e.b)) return false;
    }
    return true;
  }

 private:
  struct Entry {
    double length;
    GlobalId ga, gb;  // ga < gb
    VertId a, b;
    bool operator<(const Entry& o) const noexcept {
      if (length != o.length) return length < o.length;
      return ga != o.ga ? ga > o.ga : gb > o.gb;
    }
  };
  /// How many splits have led to this vertex; the same in all parts that have it.
  [[nodiscard]] int generation(VertId v) const noexcept { return idx(v) < generation_.size() ? generation_[v] : 0; }

  void collect();
  void enqueue(VertId a, VertId b);
  void add_face(TetId t, int side);
  void remove_face(TetId t, int side);
  /// As far as this part knows: the geometry must give the same place whatever fans of the edge a part has.
  EdgeKind kind_of(VertId a, VertId b);
  bool split(VertId a, VertId b);
  bool split_fan(TetId t, VertId a, VertId b, VertId p);
  [[nodiscard]] bool is_interface(TetId t, int side) const noexcept {
    return part_.mesh.tet2face[t][side] == kNoFace && !is_hull(part_.mesh.face_tag[t][side]);
  }

  Part& part_;
  IdVector<VertId, GlobalId>& gid_;
  Cavity cavity_;
  KeptVerts keep_;
  double longest_;
  IdVector<VertId, int> generation_;  ///< as far as there are new vertices
  Shell shell_;
  std::priority_queue<Entry> queue_;
  EdgeFaces faces_;
  std::vector<Third> ends_;
};

void InterfaceRefiner::enqueue(VertId a, VertId b) {
  const bool keep_a = keep_.has(part_.mesh, a), keep_b = keep_.has(part_.mesh, b);
  if (keep_a && keep_b) return;
  const FeatureEdge* feature = part_.mesh.feature(a, b);
  if (feature != nullptr && feature->has(kRequiredEdge | kContactEdge)) return;
  if ((keep_a && generation(b) >= kDeepest) || (keep_b && generation(a) >= kDeepest)) return;
  if (gid_[b] < gid_[a]) std::swap(a, b);
  const double l = shared_length(part_, a, b);
  if (l > longest_) queue_.push({l, gid_[a], gid_[b], a, b});
}

void InterfaceRefiner::add_face(TetId t, int side) {
  const auto v = part_.mesh.verts(make_face(t, side));
  for (std::size_t i = 0; i < 3; ++i) faces_.insert(v[i], v[(i + 1) % 3], {v[(i + 2) % 3], t});
}

void InterfaceRefiner::remove_face(TetId t, int side) {
  const auto v = part_.mesh.verts(make_face(t, side));
  for (std::size_t i = 0; i < 3; ++i) faces_.erase(v[i], v[(i + 1) % 3], {v[(i + 2) % 3], t});
}

void InterfaceRefiner::collect() {
  const TetMesh& m = part_.mesh;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t f = 0; f < 4; ++f) {
      if (!is_interface(t, f)) continue;
      add_face(t, f);
      const auto v = m.verts(make_face(t, f));
      for (std::size_t i = 0; i < 3; ++i) {
        // Each edge once: when its first face comes.
        int faces = 0;
        faces_.for_each(v[i], v[(i + 1) % 3], [&](const Third&) { ++faces; });
        if (faces == 1) enqueue(v[i], v[(i + 1) % 3]);
      }
    }
  }
}

bool InterfaceRefiner::split_fan(TetId t, VertId a, VertId b, VertId p) {
  TetMesh& m = part_.mesh;
  if (!gather_shell(m, t, a, b, shell_)) return false;
  cavity_.clear();
  for (int i = 0; i < shell_.n; ++i) cavity_.add(shell_.tet[i]);
  for (const TetId o : cavity_.old_tets()) {
    const auto tv = m.tet2vert[o];
    for (const VertId end : {a, b}) {  // the half that keeps `end`: p in place of the other one
      auto half = tv;
      half[local_index(tv, end == a ? b : a)] = p;
      if (!cavity_.propose(half[0], half[1], half[2], half[3], m.tet_ref[o], 0)) return false;
    }
    for (std::size_t f = 0; f < 4; ++f) {
      if (is_interface(o, f)) remove_face(o, f);
    }
  }
  for (int i = 0; i < shell_.ring_size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (shell_.tag[k] == 0) continue;
    cavity_.wall(a, p, shell_.ring[k], shell_.tag[k]);
    cavity_.wall(p, b, shell_.ring[k], shell_.tag[k]);
    m.vert_class[p] |= kSurface;
  }
  cavity_.commit();
  for (const TetId n : cavity_.new_tets()) {
    for (std::size_t f = 0; f < 4; ++f) {
      if (is_interface(n, f)) add_face(n, f);
    }
  }
  return true;
}

EdgeKind InterfaceRefiner::kind_of(VertId a, VertId b) {
  const TetMesh& m = part_.mesh;
  bool surface = false;
  if (m.has(a, kSurface) && m.has(b, kSurface)) {
    for (const Third& d : ends_) {
      if (!surface && gather_shell(m, d.tet, a, b, shell_)) surface = shell_.tagged_faces() != 0;
    }
  }
  if (m.feature(a, b) != nullptr) return surface ? EdgeKind::kRidge : EdgeKind::kLine;
  return surface ? EdgeKind::kSurface : EdgeKind::kInside;
}

bool InterfaceRefiner::split(VertId a, VertId b) {
  TetMesh& m = part_.mesh;
  ends_.clear();
  faces_.for_each(a, b, [&](const Third& d) { ends_.push_back(d); });
  if (ends_.empty()) return true;
  const EdgeKind kind = kind_of(a, b);
  // On the straight edge, so that both sides can make it whatever lies behind; later rounds move it onto the surface.
  const Vec3 x = shared_middle(m.coords[a], m.coords[b]);
  const SurfacePlace place =
      kind == EdgeKind::kInside ? SurfacePlace::kUnknown : part_.geometry->middle(m, a, b, kind).place;
  const VertId p = new_vertex(part_, x, shared_middle(part_.mesh.log_metric[a], part_.mesh.log_metric[b]), {}, kFrozen);
  if (!m.surface_place.empty()) m.surface_place[p] = place;
  gid_.resize(m.vert_slots(), kNoGlobal);
  gid_[p] = hashed_id(gid_[a], gid_[b]);
  generation_.resize(m.vert_slots(), 0);
  generation_[p] = 1 + std::max(generation(a), generation(b));
  // Several fans of this part may meet at the edge, with other parts between them.
  for (TetId left = ends_.front().tet; left != kNoTet;) {
    if (!split_fan(left, a, b, p)) return false;
    left = kNoTet;
    faces_.for_each(a, b, [&](const Third& d) { left = d.tet; });
  }
  const FeatureEdge* feature = m.feature(a, b);
  if (feature != nullptr) {
    m.vert_class[p] |= kRidge | class_on(feature->edge_class);
    m.features.split(a, b, p);
  }
  ++part_.counts.insert;
  enqueue(a, p);
  enqueue(p, b);
  for (auto d = ends_.begin(); d != ends_.end(); ++d) {
    const auto same = [&](const Third& o) { return o.c == d->c; };
    if (std::none_of(ends_.begin(), d, same)) enqueue(p, d->c);
  }
  return true;
}

}  // namespace

bool refine_interface(Part& part, IdVector<VertId, GlobalId>& gid, KeptVerts keep, double times) {
  return InterfaceRefiner(part, gid, keep, times * part.options.method.lengths.split_above).run();
}

}  // namespace skein
