// Meshes as arrays for the tests of the library: a cube in slices and in parts, and what must hold of a result.
#pragma once
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "comm/file.hpp"
#include "skein/skein.hpp"
#include "tests/support/whole_mesh.hpp"

namespace skein::test {

using Point = std::array<double, 3>;

inline int rank_in(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}
inline int ranks_in(MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

/// The items of a list that belong to this rank's even slice.
template <class T>
std::vector<T> slice_of(MPI_Comm comm, const std::vector<T>& all) {
  const Slice s = even_slice(std::ssize(all), Rank{rank_in(comm)}, ranks_in(comm));
  return {all.begin() + s.first, all.begin() + s.last};
}

inline std::vector<Point> points(const std::vector<Vec3>& coords) {
  std::vector<Point> out;
  for (const Vec3& x : coords) out.push_back({x.x, x.y, x.z});
  return out;
}

inline SlicedMesh sliced(MPI_Comm comm, const WholeMesh& w) {
  SlicedMesh m;
  m.coords = slice_of(comm, points(w.coords));
  m.tets = slice_of(comm, w.tets), m.tet_refs = slice_of(comm, w.tet_ref);
  m.triangles = slice_of(comm, w.tris), m.triangle_refs = slice_of(comm, w.tri_ref);
  m.edges = slice_of(comm, w.edges), m.edge_refs = slice_of(comm, w.edge_ref);
  return m;
}

/// The same in parts: tetrahedra in slices with their vertices, local numbers in no special order. Triangles and edges
/// are on every rank that has their vertices. Global numbers are `stride` apart.
inline PartitionedMesh parts(MPI_Comm comm, const WholeMesh& w, std::int64_t stride = 1) {
  PartitionedMesh m;
  std::map<std::int64_t, std::int32_t> local;
  const auto tets = slice_of(comm, w.tets);
  for (auto t = tets.rbegin(); t != tets.rend(); ++t) {
    for (const std::int64_t v : *t) {
      if (!local.emplace(v, static_cast<std::int32_t>(m.coords.size())).second) continue;
      const Vec3& x = w.coords[static_cast<std::size_t>(v)];
      m.coords.push_back({x.x, x.y, x.z});
      m.local2global.push_back(v * stride);
    }
  }
  for (const auto& t : tets) m.tets.push_back({local[t[0]], local[t[1]], local[t[2]], local[t[3]]});
  m.tet_refs = slice_of(comm, w.tet_ref);
  std::map<std::array<std::int64_t, 3>, int> faces;  // of the local tetrahedra
  const auto sorted = [](auto face) { return std::sort(face.begin(), face.end()), face; };
  for (const auto& t : tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      ++faces[sorted(std::array{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]})];
    }
  }
  for (std::size_t i = 0; i < w.tris.size(); ++i) {
    const auto& t = w.tris[i];
    if (faces.count(sorted(t)) == 0) continue;
    m.triangles.push_back({local[t[0]], local[t[1]], local[t[2]]});
    m.triangle_refs.push_back(w.tri_ref[i]);
  }
  for (std::size_t i = 0; i < w.edges.size(); ++i) {
    const auto& e = w.edges[i];
    if (local.count(e[0]) == 0 || local.count(e[1]) == 0) continue;
    m.edges.push_back({local[e[0]], local[e[1]]});
    m.edge_refs.push_back(w.edge_ref[i]);
  }
  return m;
}

/// Two linear functions of the place.
inline std::array<double, 2> linear(const Point& x) {
  return {1 + 2 * x[0] - 3 * x[1] + 0.5 * x[2], -4 + x[0] + x[1] + x[2]};
}
inline Fields linear_fields(const std::vector<Point>& coords) {
  Fields f{2, {}};
  for (const Point& x : coords) {
    const auto v = linear(x);
    f.values.insert(f.values.end(), v.begin(), v.end());
  }
  return f;
}
/// Largest difference from linear() over all ranks.
inline double worst_error(MPI_Comm comm, const std::vector<Point>& coords, const Fields& fields) {
  double worst = fields.values.size() == 2 * coords.size() ? 0 : 1e300;
  for (std::size_t i = 0; i < coords.size() && worst < 1e300; ++i) {
    const auto v = linear(coords[i]);
    for (std::size_t c = 0; c < 2; ++c) worst = std::max(worst, std::abs(fields.values[2 * i + c] - v[c]));
  }
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE, MPI_MAX, comm);
  return worst;
}

/// Counts how many communicators there are more than at the beginning: duplicates of `comm` get a copy of an attribute.
class LeakCounter {
 public:
  explicit LeakCounter(MPI_Comm comm) : comm_(comm) {
    MPI_Comm_create_keyval(&copied, &deleted, &key_, this);
    MPI_Comm_set_attr(comm_, key_, this);
  }
  ~LeakCounter() {
    MPI_Comm_delete_attr(comm_, key_);
    MPI_Comm_free_keyval(&key_);
  }
  LeakCounter(const LeakCounter&) = delete;
  LeakCounter& operator=(const LeakCounter&) = delete;
  [[nodiscard]] int made() const { return made_; }
  [[nodiscard]] int left() const { return left_; }

 private:
  static int copied(MPI_Comm, int, void*, void* in, void* out, int* flag) {
    auto* me = static_cast<LeakCounter*>(in);
    ++me->made_, ++me->left_;
    *static_cast<void**>(out) = in;
    *flag = 1;
    return MPI_SUCCESS;
  }
  static int deleted(MPI_Comm, int, void* value, void*) {
    --static_cast<LeakCounter*>(value)->left_;
    return MPI_SUCCESS;
  }
  MPI_Comm comm_;
  int key_ = MPI_KEYVAL_INVALID, made_ = 0, left_ = 0;
};

}  // namespace skein::test
