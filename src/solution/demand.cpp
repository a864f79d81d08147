// Integrals of a log-linear density, and the memory of the machine.
#include "solution/demand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "metric/complexity.hpp"

namespace skein {
namespace {

/// Logarithms that differ by less than this are integrated by the quadrature.
constexpr double kSmooth = 2;

using Triangular = std::array<std::array<double, 4>, 4>;
Triangular product(const Triangular& a, const Triangular& b) noexcept {
  Triangular c{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i; j < 4; ++j) {
      for (std::size_t k = i; k <= j; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

/// The mean of exp(l), l linear with these values at the vertices: six times the divided difference of exp, which is an
/// entry of the exponential of a bidiagonal matrix (Taylor series of a small multiple, squared).
double mean_exp(const AtVerts& l) noexcept {
  const auto [low, high] = std::minmax_element(l.begin(), l.end());
  const double shift = *high;
  const int halvings = std::max(0, std::ilogb(*high - *low + 1) + 2);
  const double scale = std::ldexp(1.0, -halvings);
  Triangular a{}, sum{}, term{};
  for (std::size_t i = 0; i < 4; ++i) {
    a[i][i] = scale * (l[i] - shift);
    if (i < 3) a[i][i + 1] = scale;
    sum[i][i] = term[i][i] = 1;
  }
  for (int n = 1; n <= 14; ++n) {
    term = product(term, a);
    for (auto& row : term) {
      for (double& x : row) x /= n;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i; j < 4; ++j) sum[i][j] += term[i][j];
    }
  }
  for (int h = 0; h < halvings; ++h) sum = product(sum, sum);
  return 6 * sum[0][3] * std::exp(shift);
}

}  // namespace

double predicted_tets(const Comm& comm, const DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  double sum = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    AtVerts l;
    for (std::size_t k = 0; k < 4; ++k) l[k] = log_sqrt_det(m.log_metric[m.tet2vert[t][k]]);
    const auto [low, high] = std::minmax_element(l.begin(), l.end());
    sum += tets_of_unit_mesh(*high - *low < kSmooth ? vertex_face_rule(l) : mean_exp(l), volume6(m, t));
  }
  return comm.sum(sum);
}

void require_affordable(const Comm& comm, const DistMesh& dist, const std::string& name, double most) {
  const double tets = predicted_tets(comm, dist);
  const auto free = static_cast<double>(free_memory(comm));
  const double needed = kBytesPerTet * tets / comm.size();
  agree(comm, [&] {
    constexpr double kGiga = 1e9;
    if (most > 0 && !(tets <= most))
      throw Error(ExitCode::kInput,
                  fmt::format("{}: about {:.3g} tetrahedra are asked for, more than the limit of {:.3g}; use coarser "
                              "sizes, a smaller --complexity, or a greater --max-elements",
                              name, tets, most));
    if (most == 0 && !(needed <= free))
      throw Error(
          ExitCode::kInput,
          fmt::format("{}: about {:.3g} tetrahedra are asked for; they need {:.3g} GB in each process, and {:.3g} "
                      "GB are free for each; use coarser sizes (are their units right?), --complexity, or more "
                      "machines; --max-elements N sets another limit",
                      name, tets, needed / kGiga, free / kGiga));
  });
}

}  // namespace skein
