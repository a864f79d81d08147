// Recovery of first and second derivatives by lumped, volume-weighted means.
#include "solution/hessian.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace skein {
namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(SymTensor) == 6 * sizeof(double));

template <class T>
std::span<double> numbers(std::vector<T>& v) noexcept {
  return {reinterpret_cast<double*>(v.data()), v.size() * (sizeof(T) / sizeof(double))};
}

/// Six times the volume, and the gradients of the four linear shape functions times that.
struct Shape {
  double volume6;
  std::array<Vec3, 4> gradient;
};

Shape shape(const TetMesh& mesh, TetId t) noexcept {
  const auto& v = mesh.tet2vert[t];
  const Vec3 a = mesh.coords[v[0]], e1 = mesh.coords[v[1]] - a, e2 = mesh.coords[v[2]] - a, e3 = mesh.coords[v[3]] - a;
  Shape s;
  s.gradient[1] = cross(e2, e3);
  s.gradient[2] = cross(e3, e1);
  s.gradient[3] = cross(e1, e2);
  s.gradient[0] = -1.0 * (s.gradient[1] + s.gradient[2] + s.gradient[3]);
  s.volume6 = dot(e1, s.gradient[1]);
  return s;
}

/// Six times the volume of all tetrahedra at each vertex, over all ranks.
std::vector<double> patch_volumes6(const TetMesh& mesh, const Halo& halo) {
  std::vector<double> volume(mesh.vert_slots(), 0);
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    const double v6 = volume6(mesh, t);
    for (const VertId v : mesh.tet2vert[t]) volume[idx(v)] += v6;
  }
  halo.sum(std::span(volume));
  return volume;
}

/// value = value / volume at every vertex (a vertex without volume keeps zero).
template <class T>
void divide(std::vector<T>& value, const std::vector<double>& volume) noexcept {
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = volume[i] > 0 ? (1 / volume[i]) * value[i] : T{};
}

std::vector<Vec3> gradient(const TetMesh& mesh, const Halo& halo, const std::vector<double>& volume,
                           std::span<const double> scalar) {
  std::vector<Vec3> g(mesh.vert_slots());
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    const auto& v = mesh.tet2vert[t];
    const Shape s = shape(mesh, t);
    // Differences, so that a large constant does not cost digits.
    Vec3 sum;
    for (std::size_t k = 1; k < 4; ++k) sum += (scalar[idx(v[k])] - scalar[idx(v[0])]) * s.gradient[k];
    for (const VertId w : v) g[idx(w)] += sum;
  }
  halo.sum(numbers(g), 3);
  divide(g, volume);
  return g;
}

/// The symmetric part of the recovered gradient of a vector field.
std::vector<SymTensor> symmetric_gradient(const TetMesh& mesh, const Halo& halo, const std::vector<double>& volume,
                                          const std::vector<Vec3>& field) {
  std::vector<SymTensor> h(mesh.vert_slots());
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    const auto& v = mesh.tet2vert[t];
    const Shape s = shape(mesh, t);
    SymTensor sum;
    for (std::size_t k = 1; k < 4; ++k) {
      const Vec3 d = field[idx(v[k])] - field[idx(v[0])], n = s.gradient[k];
      sum = sum + SymTensor{d.x * n.x,
                            0.5 * (d.x * n.y + d.y * n.x),
                            d.y * n.y,
                            0.5 * (d.x * n.z + d.z * n.x),
                            0.5 * (d.y * n.z + d.z * n.y),
                            d.z * n.z};
    }
    for (const VertId w : v) h[idx(w)] = h[idx(w)] + sum;
  }
  halo.sum(numbers(h), 6);
  divide(h, volume);
  return h;
}

/// Directions that the edges span less than this part of all are not corrected.
constexpr double kLeastSpan = 1e-3;

/// 1 at vertices of hull faces of any rank, 0 elsewhere.
std::vector<std::int32_t> hull_vertices(const TetMesh& mesh, const Halo& halo) {
  std::vector<std::int32_t> hull(mesh.vert_slots(), 0);
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    for (std::size_t side = 0; side < 4; ++side) {
      if (!is_hull(mesh.face_tag[t][side])) continue;
      for (const VertId v : mesh.verts(make_face(t, side))) hull[idx(v)] = 1;
    }
  }
  halo.max(std::span(hull));
  return hull;
}

/// Corrects the gradient at hull vertices, where the one-sided mean is off by the cell size times the curvature.
/// Along an edge e from an inner vertex w to v a quadratic function has u(v) - u(w) = (g(v) + g(w)) e / 2. The least
/// change of g(v) that satisfies this for the inner neighbours, weighted by the tetrahedra between, makes it exact for
/// quadratic functions where g(w) is and the edges span space; directions without an edge keep their value.
void correct_hull(const TetMesh& mesh, const Halo& halo, const std::vector<std::int32_t>& hull,
                  std::span<const double> scalar, std::vector<Vec3>& g) {
  struct Normal {  // matrix * change = right
    SymTensor matrix;
    Vec3 right;
  };
  static_assert(sizeof(Normal) == 9 * sizeof(double));
  std::vector<Normal> normal(g.size());
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    const double v6 = volume6(mesh, t);
    for (const auto& edge : kEdgeVerts) {
      VertId v = mesh.tet2vert[t][edge[0]], w = mesh.tet2vert[t][edge[1]];
      if (hull[idx(v)] == hull[idx(w)]) continue;
      if (hull[idx(v)] == 0) std::swap(v, w);
      const Vec3 e = mesh.coords[v] - mesh.coords[w];
      const double weight = v6 / dot(e, e);
      const double missing = 2 * (scalar[idx(v)] - scalar[idx(w)]) - dot(g[idx(v)] + g[idx(w)], e);
      Normal& n = normal[idx(v)];
      n.matrix = n.matrix + weight * SymTensor{e.x * e.x, e.x * e.y, e.y * e.y, e.x * e.z, e.y * e.z, e.z * e.z};
      n.right += weight * missing * e;
    }
  }
  halo.sum(numbers(normal), 9);
  for (std::size_t i = 0; i < g.size(); ++i) {
    const SymTensor& m = normal[i].matrix;
    const double trace = m.xx + m.yy + m.zz;
    if (!(trace > 0)) continue;
    const Eigen e = eigen(m);
    for (std::size_t k = 0; k < 3; ++k)
      g[i] += (dot(e.vector[k], normal[i].right) / (e.value[k] + kLeastSpan * trace)) * e.vector[k];
  }
}

/// Gives every vertex marked in `open` the mean of its unmarked neighbours, weighted by the tetrahedra between them,
/// and unmarks it. Returns how many this changed, over all ranks (shared vertices counted on each).
std::int64_t fill_from_neighbours(const Comm& comm, const TetMesh& mesh, const Halo& halo,
                                  std::vector<std::int32_t>& open, std::vector<SymTensor>& h) {
  std::vector<SymTensor> sum(h.size());
  std::vector<double> weight(h.size(), 0);
  for (const TetId t : IdRange<TetId>(mesh.tet_slots())) {
    const auto& verts = mesh.tet2vert[t];
    SymTensor known;
    int count = 0;
    for (const VertId v : verts) {
      if (open[idx(v)] != 0) continue;
      known = known + h[idx(v)];
      ++count;
    }
    if (count == 0 || count == 4) continue;
    const double v6 = volume6(mesh, t);
    for (const VertId v : verts) {
      if (open[idx(v)] == 0) continue;
      sum[idx(v)] = sum[idx(v)] + v6 * known;
      weight[idx(v)] += v6 * count;
    }
  }
  halo.sum(numbers(sum), 6);
  halo.sum(std::span(weight));
  std::int64_t changed = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (!(weight[i] > 0)) continue;
    h[i] = (1 / weight[i]) * sum[i];
    open[i] = 0;
    ++changed;
  }
  return comm.sum(changed);
}

void check_scalar(const Comm& comm, const DistMesh& dist, std::span<const double> scalar) {
  agree(comm, [&] {
    if (scalar.size() != dist.mesh.vert_slots())
      throw Error(ExitCode::kInternal,
                  fmt::format("the solution has {} values for {} vertices", scalar.size(), dist.mesh.vert_slots()));
    for (const VertId v : IdRange<VertId>(scalar.size())) {
      if (std::isfinite(scalar[idx(v)])) continue;
      throw Error(ExitCode::kInput, fmt::format("the solution is {} at vertex {}; all values must be finite numbers",
                                                scalar[idx(v)], num(dist.vert2gid[v]) + 1));
    }
  });
}

}  // namespace

std::vector<Vec3> recover_gradient(const Comm& comm, const DistMesh& dist, const Halo& halo,
                                   std::span<const double> scalar) {
  check_scalar(comm, dist, scalar);
  return gradient(dist.mesh, halo, patch_volumes6(dist.mesh, halo), scalar);
}

std::vector<SymTensor> recover_hessian(const Comm& comm, const DistMesh& dist, const Halo& halo,
                                       std::span<const double> scalar) {
  check_scalar(comm, dist, scalar);
  const auto volume = patch_volumes6(dist.mesh, halo);
  auto g = gradient(dist.mesh, halo, volume, scalar);
  auto open = hull_vertices(dist.mesh, halo);
  correct_hull(dist.mesh, halo, open, scalar, g);
  auto h = symmetric_gradient(dist.mesh, halo, volume, g);
  // Two layers reach the corners of a box; vertices still open then (a mesh without inner vertices) keep their value.
  for (int layer = 0; layer < 4 && fill_from_neighbours(comm, dist.mesh, halo, open, h) > 0; ++layer) {
  }
  return h;
}

}  // namespace skein
