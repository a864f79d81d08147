// Weighted quantiles of distributed keys, for partitions along a curve.
#include "partition/hilbert.hpp"

#include <algorithm>
#include <array>

#include "base/radix_sort.hpp"

namespace skein {
namespace {

/// Work of the local keys below any key, by the sorted keys and their running sums.
class WorkBelow {
 public:
  WorkBelow(std::span<const std::uint64_t> keys, std::span<const double> work) : sorted_(keys.size()) {
    for (std::size_t i = 0; i < keys.size(); ++i) sorted_[i] = {keys[i], static_cast<std::uint32_t>(i)};
    radix_sort(sorted_);
    sum_.resize(keys.size() + 1, 0.0);
    for (std::size_t i = 0; i < keys.size(); ++i) sum_[i + 1] = sum_[i] + work[sorted_[i].index];
  }
  [[nodiscard]] double operator()(std::uint64_t key) const noexcept {
    const auto it = std::lower_bound(sorted_.begin(), sorted_.end(), key,
                                     [](const KeyIndex& k, std::uint64_t v) { return k.key < v; });
    return sum_[it - sorted_.begin()];
  }
  [[nodiscard]] double total() const noexcept { return sum_.back(); }

 private:
  std::vector<KeyIndex> sorted_;
  std::vector<double> sum_;
};

constexpr int kKeyBits = 64, kStepBits = 4;
constexpr std::size_t kProbes = (1u << kStepBits) - 1;

}  // namespace

Box global_box(const Comm& comm, std::span<const Vec3> points) {
  const Box mine = bounding_box(points);
  std::array<double, 6> b{mine.low.x, mine.low.y, mine.low.z, -mine.high.x, -mine.high.y, -mine.high.z};
  comm.reduce(std::span<double>(b), Op::kMin);
  return {{b[0], b[1], b[2]}, {-b[3], -b[4], -b[5]}};
}

std::vector<PartId> cut_keys(const Comm& comm, std::span<const std::uint64_t> keys, std::span<const double> work,
                             int parts) {
  if (parts == 1) return std::vector<PartId>(keys.size(), PartId{0});
  const WorkBelow below(keys, work);
  const double total = comm.sum(below.total());
  const auto cuts = static_cast<std::size_t>(std::max(0, parts - 1));
  // low[p]: the largest key known with less than the wanted work below it. Each step tries 15 keys above it.
  std::vector<std::uint64_t> low(cuts, 0);
  std::vector<double> probe(cuts * kProbes);
  for (int shift = kKeyBits - kStepBits; shift >= 0; shift -= kStepBits) {
    for (std::size_t p = 0; p < cuts; ++p) {
      for (std::size_t k = 0; k < kProbes; ++k)
        probe[p * kProbes + k] = below(low[p] + (static_cast<std::uint64_t>(k + 1) << shift));
    }
    comm.reduce(std::span<double>(probe), Op::kSum);
    for (std::size_t p = 0; p < cuts; ++p) {
      const double wanted = total * static_cast<double>(p + 1) / static_cast<double>(parts);
      std::size_t k = 0;
      while (k < kProbes && probe[p * kProbes + k] < wanted) ++k;
      low[p] += static_cast<std::uint64_t>(k) << shift;
    }
  }
  // low[p] is now the key whose work crosses the wanted sum: it is the last one below the cut.
  std::vector<PartId> part(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i)
    part[i] = to_id<PartId>(std::lower_bound(low.begin(), low.end(), keys[i]) - low.begin());
  return part;
}

}  // namespace skein
