// The grid of cells in which faces of the hull meet, and what is made of their contacts.
#include "dist/hull_contact.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>

#include "base/hash.hpp"
#include "dist/rendezvous.hpp"
#include "mesh/triangle_contact.hpp"

namespace skein {
namespace {

constexpr int kLevels = 21;
using Levels = std::array<std::int64_t, kLevels>;

/// A cube cut into 8^level cells at each level.
class Grid {
 public:
  /// Collective.
  Grid(const Comm& comm, const std::vector<HullFace>& faces) {
    Box box = kEmptyBox;
    for (const HullFace& f : faces) box = join(box, bounding_box(f.x));
    std::array<double, 6> ends{box.low.x, box.low.y, box.low.z, -box.high.x, -box.high.y, -box.high.z};
    comm.reduce(std::span<double>(ends), Op::kMin);
    low_ = {ends[0], ends[1], ends[2]};
    side_ = std::max({-ends[3] - ends[0], -ends[4] - ends[1], -ends[5] - ends[2]});
    if (!(side_ > 0)) side_ = 1;
  }
  /// The finest level whose cells are at least twice as large as the box.
  [[nodiscard]] int level_of(const Box& b) const noexcept {
    const double extent = std::max({b.high.x - b.low.x, b.high.y - b.low.y, b.high.z - b.low.z});
    return extent > 0 ? std::clamp(std::ilogb(side_ / (2 * extent)), 0, kLevels - 1) : kLevels - 1;
  }
  [[nodiscard]] std::uint64_t key(int level, Vec3 p) const noexcept {
    return key(level, place(level, p.x - low_.x), place(level, p.y - low_.y), place(level, p.z - low_.z));
  }
  template <class F>
  void for_each_cell(int level, const Box& b, F&& f) const {
    const auto k1 = place(level, b.high.z - low_.z);
    const auto j1 = place(level, b.high.y - low_.y), i1 = place(level, b.high.x - low_.x);
    for (auto k = place(level, b.low.z - low_.z); k <= k1; ++k) {
      for (auto j = place(level, b.low.y - low_.y); j <= j1; ++j) {
        for (auto i = place(level, b.low.x - low_.x); i <= i1; ++i) f(key(level, i, j, k));
      }
    }
  }

 private:
  [[nodiscard]] std::int64_t place(int level, double x) const noexcept {
    return static_cast<std::int64_t>(std::floor(std::ldexp(x / side_, level)));
  }
  static std::uint64_t key(int level, std::int64_t i, std::int64_t j, std::int64_t k) noexcept {
    const auto part = [](std::int64_t n) { return static_cast<std::uint64_t>(n + 1) & 0x1fffff; };  // from -1 on
    return mix_pair(part(i) << 42 | part(j) << 21 | part(k), static_cast<std::uint64_t>(level + 1));
  }
  Vec3 low_;
  double side_ = 1;
};

/// A little more than the face, so that those within the tolerance meet.
Box wide_box(const HullFace& f) noexcept {
  const ContactTriangle t = contact_triangle(f.gid, f.x);
  const double tol = 2 * contact_tolerance(t, t);
  const Vec3 more{tol, tol, tol};
  return {t.box.low - more, t.box.high + more};
}

/// A face in a cell.
struct CellFace {
  std::uint64_t key;
  HullFace face;
  Box box;
  std::int32_t level;    ///< of the cell
  std::int32_t visitor;  ///< 1: smaller than those that the cell is for
};

struct Question {
  std::uint64_t key;
  std::uint64_t own;  ///< 1: there is a face of the cell's size
};
bool by_key(const Question& a, const Question& b) noexcept { return a.key != b.key ? a.key < b.key : a.own > b.own; }
/// Each key once, own if any is.
void unite(std::vector<Question>& q) {
  std::sort(q.begin(), q.end(), by_key);
  q.erase(std::unique(q.begin(), q.end(), [](const auto& a, const auto& b) { return a.key == b.key; }), q.end());
}

/// The cells of this rank's faces, and who else is in them.
class Cells {
 public:
  /// Collective.
  Cells(const Comm& comm, const std::vector<HullFace>& faces) : comm_(comm), faces_(faces), grid_(comm, faces) {
    for (const HullFace& f : faces) {
      box_.push_back(wide_box(f));
      level_.push_back(grid_.level_of(box_.back()));
      used_[static_cast<std::size_t>(level_.back())] = 1;
    }
    comm.reduce(std::span<std::int64_t>(used_), Op::kMax);
    find_occupied();
  }
  /// Collective. The faces of the cells of which this rank takes care.
  [[nodiscard]] std::vector<CellFace> meet() const {
    std::vector<CellFace> send;
    std::vector<Rank> dest;
    for_each_cell([&](std::size_t i, int level, std::uint64_t key) {
      const bool visitor = level != level_[i];
      if (visitor && !std::binary_search(occupied_.begin(), occupied_.end(), key)) return;
      send.push_back({key, faces_[i], box_[i], level, visitor ? 1 : 0});
      dest.push_back(meeting_rank(key, comm_.size()));
    });
    return exchange_items(comm_, dest, send).items;
  }
  [[nodiscard]] const Grid& grid() const noexcept { return grid_; }

 private:
  /// f(face, level, key) for the cells of its own level and of coarser ones that are in use.
  template <class F>
  void for_each_cell(F&& f) const {
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      for (int level = 0; level <= level_[i]; ++level) {
        if (used_[static_cast<std::size_t>(level)] == 0) continue;
        grid_.for_each_cell(level, box_[i], [&](std::uint64_t key) { f(i, level, key); });
      }
    }
  }
  /// Collective. The cells of coarser levels in which there is a face of their size.
  void find_occupied() {
    std::vector<Question> questions;
    std::array<std::uint64_t, kLevels> last{};
    for_each_cell([&](std::size_t i, int level, std::uint64_t key) {
      auto& before = last[static_cast<std::size_t>(level)];
      if (level != level_[i] && before == key) return;  // neighbours in the list are neighbours in space
      before = key;
      questions.push_back({key, level == level_[i] ? 1u : 0u});
    });
    unite(questions);
    std::vector<Rank> dest;
    for (const Question& q : questions) dest.push_back(meeting_rank(q.key, comm_.size()));
    const Inquiry<Question> inquiry(comm_, dest, questions);
    auto known = inquiry.asked().items;
    unite(known);
    std::vector<std::uint8_t> answers;
    for (const Question& q : inquiry.asked().items) {
      const auto at = std::lower_bound(known.begin(), known.end(), Question{q.key, 1}, by_key);
      answers.push_back(at != known.end() && at->key == q.key && at->own != 0 ? 1 : 0);
    }
    const auto occupied = inquiry.answer(answers);
    for (std::size_t i = 0; i < questions.size(); ++i) {
      if (occupied[i] != 0) occupied_.push_back(questions[i].key);
    }
  }

  const Comm& comm_;
  const std::vector<HullFace>& faces_;
  Grid grid_;
  std::vector<Box> box_;
  std::vector<int> level_;
  Levels used_{};
  std::vector<std::uint64_t> occupied_;  ///< ascending
};

/// Two vertices at one place, as two faces at them see it.
struct Twins {
  GlobalId v, w;          ///< v < w
  std::int32_t listed;    ///< 1: both faces are triangles of the file
  std::int32_t matching;  ///< 1: and match
};

/// The contacts in the cells of this rank.
class Meeting {
 public:
  Meeting(const Grid& grid, const std::vector<CellFace>& faces) : grid_(grid) {
    std::vector<std::uint32_t> order(faces.size());  // the faces themselves are too large to be moved about
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
      const CellFace &a = faces[i], &b = faces[j];
      return std::tie(a.key, a.box.low.x, a.face.tet) < std::tie(b.key, b.box.low.x, b.face.tet);
    });
    faces_.reserve(faces.size());
    triangles_.reserve(faces.size());
    for (const std::uint32_t i : order) faces_.push_back(faces[i]);
    for (const CellFace& f : faces_) triangles_.push_back(contact_triangle(f.face.gid, f.face.x));
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      for (std::size_t j = i + 1; j < faces_.size() && faces_[j].key == faces_[i].key; ++j) {
        if (faces_[j].box.low.x > faces_[i].box.high.x) break;
        if (meet_here(faces_[i], faces_[j])) judge(i, j);
      }
    }
  }
  std::vector<HullFault> faults;
  std::vector<Twins> twins;

 private:
  /// True in one of the cells that both are in.
  [[nodiscard]] bool meet_here(const CellFace& a, const CellFace& b) const noexcept {
    if (a.visitor + b.visitor == 2) return false;
    const Vec3 low{std::max(a.box.low.x, b.box.low.x), std::max(a.box.low.y, b.box.low.y),
                   std::max(a.box.low.z, b.box.low.z)};
    return contains(a.box, low) && contains(b.box, low) && a.level == b.level && grid_.key(a.level, low) == a.key;
  }
  void judge(std::size_t i, std::size_t j) {
    const ContactTriangle &a = triangles_[i], &b = triangles_[j];
    const HullFace &f = faces_[i].face, &g = faces_[j].face;
    const ContactResult r = contact_of(a, b);
    const bool listed = f.listed != 0 && g.listed != 0;
    find_twins(a, b, listed, listed && r.contact == Contact::kMatching);
    if (r.contact == Contact::kHanging) add_hanging(r.hanging, f, g);
    if (r.contact == Contact::kCovering) add_pair(HullFaultKind::kCovering, f, g);
    if (r.contact == Contact::kCrossing) add_pair(HullFaultKind::kCrossing, f, g);
  }
  void find_twins(const ContactTriangle& a, const ContactTriangle& b, bool listed, bool matching) {
    const double tol = 2 * contact_tolerance(a, b);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = 0; l < 3; ++l) {
        const Vec3 d = a.x[k] - b.x[l];
        if (a.gid[k] == b.gid[l] || std::abs(d.x) > tol || std::abs(d.y) > tol || std::abs(d.z) > tol) continue;
        const auto [v, w] = std::minmax(a.gid[k], b.gid[l]);
        twins.push_back({v, w, listed ? 1 : 0, matching ? 1 : 0});
      }
    }
  }
  void add_hanging(GlobalId vert, const HullFace& f, const HullFace& g) {
    const bool of_f = std::find(f.gid.begin(), f.gid.end(), vert) != f.gid.end();
    const auto& face = of_f ? g.gid : f.gid;
    faults.push_back({HullFaultKind::kHanging, 4, num(vert), -1, {vert, face[0], face[1], face[2]}});
  }
  void add_pair(HullFaultKind kind, const HullFace& f, const HullFace& g) {
    const HullFace &low = f.tet < g.tet ? f : g, &high = f.tet < g.tet ? g : f;
    faults.push_back({kind, 3, low.tet, high.tet, {low.gid[0], low.gid[1], low.gid[2], kNoGlobal}});
  }
  const Grid& grid_;
  std::vector<CellFace> faces_;
  std::vector<ContactTriangle> triangles_;
};

/// Collective. The pairs that are no crack, as faults; counts the others.
void judge_twins(const Comm& comm, const std::vector<Twins>& found, HullContacts& out) {
  std::vector<Rank> dest;
  for (const Twins& t : found) dest.push_back(meeting_rank(hash_of(std::array{t.v, t.w}), comm.size()));
  auto twins = exchange_items(comm, dest, found).items;
  std::sort(twins.begin(), twins.end(),
            [](const Twins& a, const Twins& b) { return std::tie(a.v, a.w) < std::tie(b.v, b.w); });
  for (std::size_t i = 0; i < twins.size();) {
    const Twins& first = twins[i];
    bool all_listed = true, any_matching = false;
    for (; i < twins.size() && twins[i].v == first.v && twins[i].w == first.w; ++i) {
      all_listed = all_listed && twins[i].listed != 0;
      any_matching = any_matching || twins[i].matching != 0;
    }
    if (all_listed || any_matching) {
      ++out.crack_verts;
    } else {
      out.faults.push_back(
          {HullFaultKind::kUnmerged, 1, num(first.v), num(first.w), {first.v, kNoGlobal, kNoGlobal, kNoGlobal}});
    }
  }
  out.crack_verts = comm.sum(out.crack_verts);
}

/// Collective. Each fault once: one vertex may hang in several faces, two tetrahedra may meet with several.
std::vector<HullFault> each_once(const Comm& comm, const std::vector<HullFault>& found) {
  std::vector<Rank> dest;
  for (const HullFault& f : found) dest.push_back(meeting_rank(to_id<GlobalId>(f.number), comm.size()));
  auto faults = exchange_items(comm, dest, found).items;
  const auto key = [](const HullFault& f) { return std::tuple(f.kind, f.number, f.other); };
  std::sort(faults.begin(), faults.end(), [&](const HullFault& a, const HullFault& b) {
    return key(a) != key(b) ? key(a) < key(b) : a.verts < b.verts;
  });
  faults.erase(
      std::unique(faults.begin(), faults.end(), [&](const auto& a, const auto& b) { return key(a) == key(b); }),
      faults.end());
  return faults;
}

}  // namespace

HullContacts find_hull_contacts(const Comm& comm, const std::vector<HullFace>& faces) {
  const Cells cells(comm, faces);
  const Meeting meeting(cells.grid(), cells.meet());
  HullContacts out;
  out.faults = each_once(comm, meeting.faults);
  judge_twins(comm, meeting.twins, out);
  return out;
}

}  // namespace skein
