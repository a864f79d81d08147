// A balanced octree over the domain, level by level as sorted lists of cell keys.
#include "generate/seeds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/hash.hpp"

namespace skein {
namespace {

constexpr int kMaxLevel = 20;
constexpr std::size_t kMaxCells = 150'000;  ///< of sources; TetGen takes some seconds for as many seeds

/// Cell of the octree: integer position among the 2^level cells per axis, 21 bits each.
struct Cell {
  std::int64_t i, j, k;
};
using Key = std::uint64_t;
constexpr Key key(Cell c) noexcept {
  return static_cast<Key>(c.i) << 42 | static_cast<Key>(c.j) << 21 | static_cast<Key>(c.k);
}
constexpr Cell cell(Key key) noexcept {
  constexpr Key kMask = (Key{1} << 21) - 1;
  return {static_cast<std::int64_t>(key >> 42), static_cast<std::int64_t>(key >> 21 & kMask),
          static_cast<std::int64_t>(key & kMask)};
}

void sort_unique(std::vector<Key>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

class Octree {
 public:
  Octree(Vec3 origin, double side) : origin_(origin), side_(side), cells_(kMaxLevel + 1) {
    cells_[0] = {key({0, 0, 0})};
  }

  [[nodiscard]] double side(int level) const noexcept { return std::ldexp(side_, -level); }
  [[nodiscard]] Vec3 centre(int level, Cell c) const noexcept {
    const double s = side(level);
    return origin_ +
           s * Vec3{static_cast<double>(c.i) + 0.5, static_cast<double>(c.j) + 0.5, static_cast<double>(c.k) + 0.5};
  }
  /// The first level whose cells are not larger than `size`.
  [[nodiscard]] int level(double size) const noexcept {
    if (!(size < side_)) return 0;
    return std::clamp(static_cast<int>(std::ceil(std::log2(side_ / size))), 0, kMaxLevel);
  }
  void want(int level, Cell c) { cells_[level].push_back(key(c)); }
  void want(int level, Vec3 x) {
    const double s = side(level);
    const auto at = [&](double d) {
      return std::clamp(static_cast<std::int64_t>(d / s), std::int64_t{0}, (std::int64_t{1} << level) - 1);
    };
    const Vec3 d = x - origin_;
    want(level, Cell{at(d.x), at(d.y), at(d.z)});
  }
  [[nodiscard]] std::size_t size() const noexcept {
    std::size_t n = 0;
    for (const auto& level : cells_) n += level.size();
    return n;
  }
  [[nodiscard]] bool has(int level, Cell c) const noexcept {
    const auto& list = cells_[level];
    return std::binary_search(list.begin(), list.end(), key(c));
  }
  [[nodiscard]] const std::vector<Key>& cells(int level) const noexcept { return cells_[level]; }
  /// All eight children exist, or none (after balance()).
  [[nodiscard]] bool is_leaf(int level, Cell c) const noexcept {
    return level == kMaxLevel || !has(level + 1, {2 * c.i, 2 * c.j, 2 * c.k});
  }

  /// Gives every cell its siblings and parent, and the parent its neighbours: neighbouring leaves differ by one level.
  void balance() {
    for (int level = kMaxLevel; level > 0; --level) {
      auto& own = cells_[level];
      sort_unique(own);
      std::vector<Key> parents;
      for (const Key k : own) parents.push_back(key({cell(k).i / 2, cell(k).j / 2, cell(k).k / 2}));
      sort_unique(parents);
      own.clear();
      for (const Key k : parents) {
        const Cell p = cell(k);
        for (int child = 0; child < 8; ++child) {
          own.push_back(key({2 * p.i + (child & 1), 2 * p.j + (child >> 1 & 1), 2 * p.k + (child >> 2)}));
        }
      }
      std::sort(own.begin(), own.end());
      add_with_neighbours(level - 1, parents);
    }
    sort_unique(cells_[0]);
  }

 private:
  void add_with_neighbours(int level, const std::vector<Key>& keys) {
    auto& list = cells_[level];
    const std::int64_t n = std::int64_t{1} << level;
    for (const Key k : keys) {
      const Cell c = cell(k);
      for (std::int64_t i = std::max<std::int64_t>(c.i - 1, 0); i <= std::min(c.i + 1, n - 1); ++i) {
        for (std::int64_t j = std::max<std::int64_t>(c.j - 1, 0); j <= std::min(c.j + 1, n - 1); ++j) {
          for (std::int64_t l = std::max<std::int64_t>(c.k - 1, 0); l <= std::min(c.k + 1, n - 1); ++l) {
            list.push_back(key({i, j, l}));
          }
        }
      }
    }
  }

  Vec3 origin_;
  double side_;
  std::vector<std::vector<Key>> cells_;  ///< per level
};

/// Cells down to `ratio` times the least spacing that the sources want anywhere in them. False when there are too many.
bool want_sources(Octree& tree, const SpacingField& sources, double ratio) {
  struct Node {
    int level;
    Cell cell;
  };
  std::size_t made = 0;
  std::vector<Node> todo{{0, {0, 0, 0}}};
  while (!todo.empty()) {
    const Node node = todo.back();
    todo.pop_back();
    const double side = tree.side(node.level);
    const Vec3 centre = tree.centre(node.level, node.cell);
    double least = sources.size_max;
    for (const Source& s : sources.sources) {
      const double d = std::max(0.0, distance(s, centre) - side * std::sqrt(3.0) / 2);
      const double spacing = d < s.r1 ? s.spacing : s.spacing * std::exp2((d - s.r1) / (s.r2 - s.r1));
      least = std::min(least, spacing);
    }
    if (side <= ratio * least || node.level == kMaxLevel) continue;
    if ((made += 8) > kMaxCells) return false;
    for (int child = 0; child < 8; ++child) {
      const Cell c{2 * node.cell.i + (child & 1), 2 * node.cell.j + (child >> 1 & 1), 2 * node.cell.k + (child >> 2)};
      tree.want(node.level + 1, c);
      todo.push_back({node.level + 1, c});
    }
  }
  return true;
}

/// Leaves whose centre is nearer to the surface than 0.6 of their side, marked in lists beside the tree's lists.
class NearSurface {
 public:
  explicit NearSurface(const Octree& tree) : tree_(tree) {
    for (int level = 0; level <= kMaxLevel; ++level) near_.emplace_back(tree.cells(level).size(), std::uint8_t{0});
  }
  void mark(const Source& triangle) {
    low_ = high_ = triangle.corner[0];
    for (const Vec3 x : triangle.corner) {
      low_ = {std::min(low_.x, x.x), std::min(low_.y, x.y), std::min(low_.z, x.z)};
      high_ = {std::max(high_.x, x.x), std::max(high_.y, x.y), std::max(high_.z, x.z)};
    }
    descend(triangle, 0, {0, 0, 0});
  }
  [[nodiscard]] bool is_near(int level, std::size_t i) const noexcept { return near_[level][i] != 0; }

 private:
  void descend(const Source& triangle, int level, Cell c) {
    const Vec3 x = tree_.centre(level, c);
    const double reach = 1.1 * tree_.side(level);  // half of the cell and 0.6 of its side
    if (x.x < low_.x - reach || x.y < low_.y - reach || x.z < low_.z - reach || x.x > high_.x + reach ||
        x.y > high_.y + reach || x.z > high_.z + reach) {
      return;
    }
    if (!tree_.is_leaf(level, c)) {
      for (int child = 0; child < 8; ++child) {
        descend(triangle, level + 1, {2 * c.i + (child & 1), 2 * c.j + (child >> 1 & 1), 2 * c.k + (child >> 2)});
      }
    } else if (distance(triangle, x) < 0.6 * tree_.side(level)) {
      const auto& list = tree_.cells(level);
      const auto at = std::lower_bound(list.begin(), list.end(), key(c)) - list.begin();
      near_[level][at] = 1;
    }
  }

  const Octree& tree_;
  Vec3 low_, high_;
  std::vector<std::vector<std::uint8_t>> near_;  ///< per level, beside tree.cells(level)
};

/// A number in [-1, 1) that follows from the key and the axis alone.
double jitter(int level, Key k, std::uint64_t axis) noexcept {
  const std::uint64_t h = mix_pair(k, axis + 3 * static_cast<std::uint64_t>(level));
  return std::ldexp(static_cast<double>(h >> 11), -52) - 1;
}

std::vector<Vec3> far_centres(const MeshSlice& surface, const Octree& tree) {
  NearSurface near(tree);
  for (const auto& t : surface.triangles.verts) {
    Source triangle;
    triangle.corners = 3;
    for (std::size_t k = 0; k < 3; ++k) triangle.corner[k] = surface.coords[idx(t[k])];
    near.mark(triangle);
  }
  std::vector<Vec3> seeds;
  for (int level = 0; level <= kMaxLevel; ++level) {
    const auto& list = tree.cells(level);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Cell c = cell(list[i]);
      if (!tree.is_leaf(level, c) || near.is_near(level, i)) continue;
      // Off the lattice: points on common planes and spheres give flat tetrahedra.
      const Vec3 shift{jitter(level, list[i], 0), jitter(level, list[i], 1), jitter(level, list[i], 2)};
      seeds.push_back(tree.centre(level, c) + (0.15 * tree.side(level)) * shift);
    }
  }
  return seeds;
}

}  // namespace

std::vector<Vec3> make_seeds(const MeshSlice& surface, const std::vector<double>& spacing, const SpacingField& sources,
                             double ratio) {
  Vec3 low = surface.coords.front(), high = low;
  for (const Vec3 x : surface.coords) {
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  const Vec3 extent = high - low;
  const double side = 1.01 * std::max({extent.x, extent.y, extent.z});
  const Vec3 origin = 0.5 * (low + high) - 0.5 * side * Vec3{1, 1, 1};
  for (;; ratio *= 2) {  // fewer seeds when they would be too many for one rank
    Octree tree(origin, side);
    if (!want_sources(tree, sources, ratio)) continue;
    for (std::size_t v = 0; v < surface.coords.size(); ++v) {
      tree.want(tree.level(ratio * std::min(spacing[v], sources.size_max)), surface.coords[v]);
    }
    tree.balance();
    if (tree.size() <= 2 * kMaxCells) return far_centres(surface, tree);
  }
}

}  // namespace skein
