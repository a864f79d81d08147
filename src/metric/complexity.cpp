// The mean of a log-linear density over a tetrahedron.
#include "metric/complexity.hpp"

#include <algorithm>

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
double divided_difference_mean(const AtVerts& l) noexcept {
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

double mean_of_log_linear(const AtVerts& l) noexcept {
  const auto [low, high] = std::minmax_element(l.begin(), l.end());
  return *high - *low < kSmooth ? vertex_face_rule(l) : divided_difference_mean(l);
}

}  // namespace skein
