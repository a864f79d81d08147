#include "advection.hpp"

#include <algorithm>
#include <cmath>

namespace {

using Vector = std::array<double, 3>;

Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The edges of a tetrahedron, each with the opposite edge, such that the order of the four is positive.
constexpr int kEdges[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};

}  // namespace

Advection::Advection(MPI_Comm comm, const skein::PartitionedMesh& mesh, Vector velocity)
    : comm_(comm), shared_(comm, mesh.local2global), own_volume_(mesh.coords.size(), 0.0) {
  std::vector<double> outflow(mesh.coords.size(), 0.0);
  for (const auto& tet : mesh.tets) {
    const Vector x[4] = {mesh.coords[tet[0]], mesh.coords[tet[1]], mesh.coords[tet[2]], mesh.coords[tet[3]]};
    const double volume = dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6;
    for (const int v : tet) own_volume_[v] += volume / 4;
    for (const auto& [i, j, k, l] : kEdges) {
      // Between the dual cells of i and j: from the edge's middle by two face centroids to the tetrahedron's. The area
      // vector points from i to j.
      const Vector area24 = cross(x[k] + x[l] - x[i] - x[j], x[l] - x[k]);
      const double rate = dot(velocity, area24) / 24;
      flows_.push_back(rate > 0 ? Flow{tet[i], tet[j], rate} : Flow{tet[j], tet[i], -rate});
      outflow[flows_.back().from] += std::abs(rate);
    }
  }
  full_volume_ = own_volume_;
  shared_.sum(full_volume_);
  shared_.sum(outflow);
  double most = 0;
  for (std::size_t v = 0; v < outflow.size(); ++v) most = std::max(most, outflow[v] / full_volume_[v]);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm_);
  step_ = 0.9 / most;
}

void Advection::advance(std::vector<double>& density, double duration) const {
  const int steps = std::max(1, static_cast<int>(std::ceil(duration / step_)));
  const double dt = duration / steps;
  std::vector<double> change;
  for (int s = 0; s < steps; ++s) {
    change.assign(density.size(), 0.0);
    for (const auto& [from, to, rate] : flows_) {
      const double flux = rate * density[from];
      change[from] -= flux;
      change[to] += flux;
    }
    shared_.sum(change);
    for (std::size_t v = 0; v < density.size(); ++v) density[v] += dt * change[v] / full_volume_[v];
  }
}

double Advection::mass(const std::vector<double>& density) const {
  double sum = 0;
  for (std::size_t v = 0; v < density.size(); ++v) sum += own_volume_[v] * density[v];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_);
  return sum;
}
