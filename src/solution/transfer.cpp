// Finding the old tetrahedra of new points: first here, then at the ranks whose boxes hold the point, and last, for
// points outside of the old mesh, at the ranks that may have its nearest point.
#include "solution/transfer.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/hilbert.hpp"
#include "base/parallel.hpp"
#include "base/radix_sort.hpp"
#include "dist/rendezvous.hpp"

namespace skein {
namespace {

constexpr double kRounding = 1e-12;  ///< of the size of the mesh: a point so near its hull counts as inside
constexpr std::size_t kBoxes = 64;   ///< round each rank's part
constexpr std::size_t kChunk =
    2048;  ///< points that a thread takes in a row; the result does not depend on the threads

/// The points along the Hilbert curve: each is near the one before it.
std::vector<std::uint32_t> space_order(std::span<const Vec3> points) {
  const Box box = bounding_box(points);
  std::vector<KeyIndex> keys(points.size());
  std::vector<std::uint64_t> key(points.size());
  hilbert_keys(points, box, key);
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = {key[i], static_cast<std::uint32_t>(i)};
  radix_sort(keys);
  std::vector<std::uint32_t> order(keys.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = keys[i].index;
  return order;
}

/// Calls take(i, place or null) for point(i), i = 0 .. n-1, in `threads` threads.
template <class Point, class Take>
void find_all(const TetLocator& locator, std::size_t n, int threads, Point&& point, Take&& take) {
  const std::size_t chunks = (n + kChunk - 1) / kChunk;
  const int workers = static_cast<int>(std::clamp<std::size_t>(chunks, 1, static_cast<std::size_t>(threads)));
  in_parallel(workers, [&](int worker) {
    for (std::size_t c = share_begin(chunks, worker, workers); c < share_begin(chunks, worker + 1, workers); ++c) {
      TetId hint = kNoTet;
      Place place;
      for (std::size_t i = c * kChunk; i < std::min(n, (c + 1) * kChunk); ++i)
        take(i, locator.find(point(i), hint, place) ? &place : nullptr);
    }
  });
}

struct Question {
  Vec3 x;
  double limit2;  ///< farther places are not wanted
};

}  // namespace

/// The state of one call of at().
struct Background::Asking {
  std::span<const Vec3> points;
  int threads;
  VertFields out;
  std::vector<std::uint32_t> missing;  ///< points that are in no tetrahedron so far, along the Hilbert curve
  std::vector<double> distance2;       ///< of each point to the place that its values are from
  std::int64_t remote = 0;
};

Background::Background(const Comm& comm, const DistMesh& dist, VertFields fields)
    : comm_(&comm), locator_(dist.mesh), fields_(std::move(fields)) {
  agree(comm, [&] {
    const std::size_t numbers = dist.mesh.vert_slots() * static_cast<std::size_t>(fields_.width);
    if (fields_.width > 0 && fields_.values.size() == numbers && dist.mesh.tet2face.size() == dist.mesh.tet_slots())
      return;
    throw Error(ExitCode::kInternal, "fields to transfer do not fit their mesh: report this as a bug");
  });
  const std::vector<Box> mine = locator_.boxes(kBoxes);
  const std::vector<Rank> owner(mine.size(), comm.rank());
  boxes_ = BoxTree(comm.all_gather(mine));
  box2rank_ = comm.all_gather(owner);
  if (!box2rank_.empty()) return;
  agree(comm, [] { throw Error(ExitCode::kInternal, "fields to transfer are on a mesh without tetrahedra"); });
}

void Background::evaluate(const Place& place, double* out) const noexcept {
  const auto& v = locator_.verts(place.tet);
  const auto& w = place.weight;
  const auto k = static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin());
  const double* base = fields_.at(v[k]);
  // Differences to the nearest vertex: constants stay exact.
  for (int c = 0; c < fields_.width; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (i != k) sum += w[i] * (fields_.at(v[i])[c] - base[c]);
    }
    out[c] = base[c] + sum;
  }
}

/// Collective. Asks rank dest[i] for the values at point who[i], and keeps the answers that are nearer than what is
/// there; of equal ones the first.
void Background::ask(Asking& a, const std::vector<Rank>& dest, const std::vector<std::uint32_t>& who,
                     Beyond beyond) const {
  std::vector<Question> questions(who.size());
  for (std::size_t i = 0; i < who.size(); ++i) questions[i] = {a.points[who[i]], a.distance2[who[i]]};
  const Inquiry<Question> inquiry(*comm_, dest, questions);
  const auto& asked = inquiry.asked().items;
  const auto width = static_cast<std::size_t>(fields_.width) + 1;  // the squared distance first
  std::vector<double> answers(asked.size() * width, 0);
  find_all(
      locator_, asked.size(), a.threads, [&](std::size_t i) { return asked[i].x; },
      [&](std::size_t i, const Place* found) {
        Place place;
        if (found != nullptr) {
          place = *found;
        } else if (beyond == Beyond::kNearest) {
          place = locator_.nearest(asked[i].x, asked[i].limit2);
        }
        answers[i * width] = place.distance2;
        if (place.tet != kNoTet) evaluate(place, &answers[i * width + 1]);
      });
  const auto got = inquiry.answer(answers, width);
  for (std::size_t i = 0; i < who.size(); ++i) {
    const double d2 = got[i * width];
    if (!(d2 < a.distance2[who[i]])) continue;
    a.distance2[who[i]] = d2;
    std::copy_n(&got[i * width + 1], width - 1, a.out.at(to_id<VertId>(who[i])));
  }
}

/// Collective. The points missing so far, at all other ranks with a box that holds them.
void Background::ask_ranks_inside(Asking& a) const {
  std::vector<Rank> dest;
  std::vector<std::uint32_t> who;
  for (const std::uint32_t i : a.missing) {
    Rank last = comm_->rank();
    boxes_.containing(a.points[i], [&](std::size_t box) {
      const Rank r = box2rank_[box];  // ascending
      if (r != last && r != comm_->rank()) {
        dest.push_back(r);
        who.push_back(i);
      }
      last = r;
      return false;
    });
  }
  ask(a, dest, who, Beyond::kNothing);
  std::erase_if(a.missing, [&](std::uint32_t i) { return a.distance2[i] == 0; });
}

/// Collective. The points that no tetrahedron holds: the rank with the nearest box tells how far the mesh is at most,
/// then all ranks with a box within that distance are asked.
void Background::ask_nearest(Asking& a) const {
  std::vector<Rank> dest(a.missing.size());
  for (std::size_t m = 0; m < dest.size(); ++m) {
    double limit2 = kInfinity;
    std::size_t nearest = box2rank_.size();
    boxes_.near(a.points[a.missing[m]], limit2, [&](std::size_t box, double d2) {
      if (d2 == limit2 && nearest < box) return;
      limit2 = d2;
      nearest = box;
    });
    dest[m] = box2rank_[nearest];
  }
  ask(a, dest, a.missing, Beyond::kNearest);

  std::vector<Rank> ranks, others;
  std::vector<std::uint32_t> who;
  for (std::size_t m = 0; m < dest.size(); ++m) {
    const std::uint32_t i = a.missing[m];
    double limit2 = a.distance2[i];
    ranks.clear();
    boxes_.near(a.points[i], limit2, [&](std::size_t box, double) { ranks.push_back(box2rank_[box]); });
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    for (const Rank r : ranks) {
      if (r == dest[m]) continue;
      others.push_back(r);
      who.push_back(i);
    }
  }
  ask(a, others, who, Beyond::kNearest);
}

/// Collective. `away`: points that this rank's own part does not hold.
TransferReport Background::make_report(const Asking& a, std::int64_t away) const {
  const Box all = boxes_.level_of_at_most(1)[0];
  const double rounding = kRounding * norm(all.high - all.low);
  double farthest2 = 0;
  std::int64_t outside = 0;
  for (const std::uint32_t i : a.missing) {
    farthest2 = std::max(farthest2, a.distance2[i]);
    outside += a.distance2[i] > rounding * rounding ? 1 : 0;
  }
  TransferReport r;
  r.points = comm_->sum(static_cast<std::int64_t>(a.points.size()));
  r.remote = comm_->sum(away - static_cast<std::int64_t>(a.missing.size()));
  r.outside = comm_->sum(outside);
  r.farthest = std::sqrt(comm_->max(farthest2));
  return r;
}

VertFields Background::at(std::span<const Vec3> points, int threads, TransferReport* report) const {
  Asking a{points, threads, {fields_.width, {}}, {}, {}};
  agree(*comm_, [&] {
    a.out.values.resize(points.size() * static_cast<std::size_t>(fields_.width));
    a.distance2.assign(points.size(), kInfinity);
    const auto order = space_order(points);
    find_all(
        locator_, order.size(), threads, [&](std::size_t i) { return points[order[i]]; },
        [&](std::size_t i, const Place* found) {
          if (found == nullptr) return;
          a.distance2[order[i]] = 0;
          evaluate(*found, a.out.at(to_id<VertId>(order[i])));
        });
    for (const std::uint32_t i : order) {
      if (a.distance2[i] > 0) a.missing.push_back(i);
    }
  });
  const auto away = static_cast<std::int64_t>(a.missing.size());
  ask_ranks_inside(a);
  ask_nearest(a);
  const TransferReport found = make_report(a, away);
  if (report != nullptr) *report = found;
  return std::move(a.out);
}

VertFields Background::at_vertices(const DistMesh& dist, int threads, TransferReport* report) const {
  VertFields out = at(dist.mesh.coords.raw(), threads, report);
  Halo(*comm_, dist.sharing).copy_from_owner(std::span(out.values), out.width);
  return out;
}

VertFields fields_of(const IdVector<VertId, SymTensor>& tensors) {
  VertFields out{6, {}};
  out.values.reserve(6 * tensors.size());
  for (const SymTensor& t : tensors) out.values.insert(out.values.end(), {t.xx, t.xy, t.yy, t.xz, t.yz, t.zz});
  return out;
}

IdVector<VertId, SymTensor> tensors_of(const VertFields& fields) {
  IdVector<VertId, SymTensor> out(fields.size());
  for (const VertId v : IdRange<VertId>(out.size())) {
    const double* t = fields.at(v);
    out[v] = {t[0], t[1], t[2], t[3], t[4], t[5]};
  }
  return out;
}

}  // namespace skein
