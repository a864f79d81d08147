// How far a mesh may be cut, and the metric of a step on the way to the final one.
#include "adapt/grow.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/tensor.hpp"
#include "comm/halo.hpp"

namespace skein {
namespace {

SymTensor coarser(const SymTensor& log_m, double factor, double own_size) noexcept {
  Eigen e = eigen(log_m);
  for (double& l : e.value) {
    const double h = std::exp(-0.5 * l);
    l = -2 * std::log(std::max(h, std::min(factor * h, 0.5 * own_size)));
  }
  return compose(e);
}

}  // namespace

CutLimits cut_limits(const Comm& comm, std::span<const double> elements, int workers, const Method::Growth& method) {
  double sum = 0, squares = 0;
  for (const double e : elements) {
    sum += e;
    squares += e * e;
  }
  sum = comm.sum(sum);
  squares = comm.sum(squares);
  const auto parts = [&](double n) { return static_cast<int>(std::clamp(n, 1.0, static_cast<double>(workers))); };
  return {parts(sum / method.smallest_part), parts(squares > 0 ? sum * sum / squares / method.smallest_cut : 1)};
}

void bound_growth(const Comm& comm, DistMesh& dist, std::span<const double> elements, double growth) {
  const TetMesh& m = dist.mesh;
  std::vector<double> sums(3 * m.vert_slots(), 0.0);  // per vertex: growth, volume and number of its tetrahedra
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const double volume = std::abs(volume6(m, t)) / 6;
    for (const VertId v : m.tet2vert[t]) {
      double* s = sums.data() + 3 * idx(v);
      s[0] += elements[idx(t)];
      s[1] += volume;
      s[2] += 1;
    }
  }
  Halo(comm, dist.sharing).sum(std::span<double>(sums), 3);
  for (const VertId v : IdRange<VertId>(m.vert_slots())) {
    const double* s = sums.data() + 3 * idx(v);
    if (s[0] <= growth * s[2]) continue;
    const double factor = std::cbrt(s[0] / s[2] / growth);
    const double own_size = std::cbrt(6 * std::sqrt(2.0) * s[1] / s[2]);  // of the regular tetrahedron of this volume
    SymTensor& l = dist.mesh.log_metric[v];
    l = coarser(l, factor, own_size);
  }
}

}  // namespace skein
