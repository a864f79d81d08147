// The fit of the quadric, by elimination of its coefficients of second degree.
#include "geometry/quadric_normal.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace skein {
namespace {

constexpr std::size_t kTerms = 9;       ///< x, y, z, then the six of second degree
constexpr double kMinCosine = 0.866;    ///< of 30 degrees
constexpr double kRegular = 1e-14;      ///< relative; keeps the elimination possible where points are too few
constexpr double kIndifferent = 1e-12;  ///< relative; directions that miss the points by less fit equally well
using Matrix = std::array<std::array<double, kTerms>, kTerms>;

/// Sum of the outer products of the terms at the points; nearer points count more.
Matrix normal_matrix(Vec3 v, std::span<const Vec3> points, double radius) {
  Matrix a{};
  for (const Vec3 p : points) {
    const Vec3 d = (1 / radius) * (p - v);
    const double r2 = dot(d, d);
    if (!(r2 > 0)) continue;
    const std::array<double, kTerms> term{d.x,       d.y,       d.z,       d.x * d.x, d.y * d.y,
                                          d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z};
    for (std::size_t i = 0; i < kTerms; ++i) {
      for (std::size_t k = 0; k < kTerms; ++k) a[i][k] += term[i] * term[k] / r2;
    }
  }
  return a;
}

/// Eliminates the unknown `k` from those below it.
void eliminate(Matrix& a, std::size_t k, double least) {
  const double pivot = a[k][k] + least;
  for (std::size_t i = 0; i < k; ++i) {
    const double f = a[i][k] / pivot;
    for (std::size_t j = 0; j < k; ++j) a[i][j] -= f * a[k][j];
  }
}

}  // namespace

Vec3 quadric_normal(Vec3 v, std::span<const Vec3> points, Vec3 guess) {
  double radius = 0;
  for (const Vec3 p : points) radius = std::max(radius, norm(p - v));
  if (!(radius > 0)) return guess;
  Matrix a = normal_matrix(v, points, radius);
  double trace = 0;
  for (std::size_t i = 0; i < kTerms; ++i) trace += a[i][i];
  for (std::size_t k = kTerms; k-- > 3;) eliminate(a, k, kRegular * trace);
  // Inverse iteration from the guess: the direction that misses the points least wins, of several equally good ones
  // their part of the guess.
  const double shift = kIndifferent * trace;
  const Vec3 r0{a[0][0] + shift, a[0][1], a[0][2]}, r1{a[1][0], a[1][1] + shift, a[1][2]},
      r2{a[2][0], a[2][1], a[2][2] + shift};
  const Vec3 c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  const double sign = dot(r0, c0) < 0 ? -1 : 1;  // of the determinant
  Vec3 n = guess;
  for (int step = 0; step < 2; ++step) n = normalized(sign * (n.x * c0 + n.y * c1 + n.z * c2));
  return is_finite(n) && dot(n, guess) > kMinCosine ? n : guess;
}

}  // namespace skein
