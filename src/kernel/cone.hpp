// Cone and Spheres: many faces or tetrahedra and one point, measured eight at a time.
#pragma once
#include <array>
#include <vector>

#include "kernel/part.hpp"

namespace skein {

/// Faces (a, b, c) that an apex on their positive side is joined to: a vertex with the faces of its ball, or a new
/// point with the border of its cavity. Coordinates and metrics are copied into blocks of eight lanes, so that the
/// compiler can use the vector unit.
class Cone {
 public:
  void clear() noexcept { size_ = 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  void add(const Part& part, VertId a, VertId b, VertId c) {
    const std::size_t l = size_ % kLanes;
    if (size_ == room_) grow();
    Block& block = blocks_[size_ / kLanes];
    ++size_;
    const Vec3 xa = part.x(a), xb = part.x(b), xc = part.x(c);
    const VertMetric &ma = part.mesh.metric[a], &mb = part.mesh.metric[b], &mc = part.mesh.metric[c];
    const VertMetric& ab = ma.order_key >= mb.order_key ? ma : mb;
    const VertMetric& m = ab.order_key >= mc.order_key ? ab : mc;
    const std::array<double, kRows> row{xa.x,   xa.y,   xa.z,   xb.x,   xb.y,   xb.z,   xc.x,       xc.y,       xc.z,
                                        m.m.xx, m.m.xy, m.m.yy, m.m.xz, m.m.yz, m.m.zz, m.sqrt_det, m.order_key};
    if (l == 0) {  // in all lanes, so that those which stay empty hold a face, too
      for (std::size_t i = 0; i < kRows; ++i) block.row[i].fill(row[i]);
    } else {
      for (std::size_t i = 0; i < kRows; ++i) block.row[i][l] = row[i];
    }
  }

  /// Q^3 of every tetrahedron (x, a, b, c), to be read by q3(i); returns the smallest. 0 where the tetrahedron is not
  /// certainly positive: its volume is within the rounding error of the orientation test.
  double judge(Vec3 x, const VertMetric& m);
  /// Of the i-th face added. @pre judge has been called since.
  [[nodiscard]] double q3(std::size_t i) const noexcept { return q3_[i / kLanes][i % kLanes]; }
  /// In the place of what judge has found.
  void set_q3(std::size_t i, double q3) noexcept { q3_[i / kLanes][i % kLanes] = q3; }
  /// Sum of 1/Q^3 after judge. @pre all of them are positive.
  [[nodiscard]] double sum_of_inverses() const noexcept;

  /// Gradient and Hessian, by the apex at x, of F = the sum of 1/Q^3 in the metric m, up to one factor in all three.
  struct Newton {
    double value = 0;
    Vec3 gradient;
    SymTensor hessian;
    bool valid = false;  ///< all volumes are positive
  };
  [[nodiscard]] Newton newton(Vec3 x, const SymTensor& m);

  /// The tetrahedron of the cone with apex x in whose direction `step` leads from x.
  struct Place {
    std::size_t face = 0;
    std::array<double, 3> weight{};  ///< barycentric weights of a, b, c at x + step; the rest is the apex's
  };
  [[nodiscard]] Place locate(Vec3 x, Vec3 step);

 private:
  static constexpr std::size_t kLanes = 8;
  using Lanes = std::array<double, kLanes>;
  /// The coordinates of a, b, c, and of their metrics the one of largest determinant.
  enum Row : std::size_t { kA = 0, kB = 3, kC = 6, kMetric = 9, kSqrtDet = 15, kOrderKey = 16, kRows = 17 };
  struct alignas(64) Block {
    std::array<Lanes, kRows> row;
    [[nodiscard]] Vec3 minus(Row at, std::size_t l, Vec3 x) const noexcept {
      return {row[at][l] - x.x, row[at + 1][l] - x.y, row[at + 2][l] - x.z};
    }
  };
  [[nodiscard]] std::size_t block_count() const noexcept { return (size_ + kLanes - 1) / kLanes; }
  /// Makes room for more faces.
  void grow();

  std::size_t size_ = 0, room_ = 0;
  std::vector<Block> blocks_;
  std::vector<Lanes> q3_;
};

/// Tetrahedra whose circumspheres, in the metric of a point, may contain it.
class Spheres {
 public:
  void clear() noexcept { size_ = 0; }
  /// A positively oriented tetrahedron.
  void add(const Part& part, const std::array<VertId, 4>& verts) {
    if (size_ == room_) grow();
    auto& to = blocks_[size_ / kLanes].x;
    const std::size_t l = size_ % kLanes;
    ++size_;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 x = part.x(verts[i]);
      to[i][0][l] = x.x, to[i][1][l] = x.y, to[i][2][l] = x.z;
    }
  }
  void test(Vec3 x, const SymTensor& m);
  /// Of the i-th tetrahedron added. @pre test has been called since.
  [[nodiscard]] bool contain(std::size_t i) const noexcept { return blocks_[i / kLanes].inside[i % kLanes] > 0; }

 private:
  static constexpr std::size_t kLanes = 8;
  using Lanes = std::array<double, kLanes>;
  struct alignas(64) Block {
    std::array<std::array<Lanes, 3>, 4> x{};  ///< of the four vertices
    Lanes inside{};                           ///< positive when the point lies inside
  };
  void grow();
  std::size_t size_ = 0, room_ = 0;
  std::vector<Block> blocks_;
};

}  // namespace skein
