// Random tensors with known eigenvalues.
#pragma once
#include <random>

#include "base/tensor.hpp"

namespace skein::test {

/// A random orthonormal frame.
inline std::array<Vec3, 3> random_frame(std::mt19937& random) {
  std::normal_distribution<double> any;
  const Vec3 a = normalized({any(random), any(random), any(random)});
  const Vec3 b = normalized(cross(a, {any(random), any(random), any(random)}));
  return {a, b, cross(a, b)};
}

/// A random metric with sizes between h and h * anisotropy (both taken).
inline SymTensor random_metric(std::mt19937& random, double h, double anisotropy) {
  std::uniform_real_distribution<double> any(0, 1);
  Eigen e;
  e.vector = random_frame(random);
  const double middle = h * std::pow(anisotropy, any(random));
  const double high = h * anisotropy;
  e.value = {1 / (high * high), 1 / (middle * middle), 1 / (h * h)};
  return compose(e);
}

}  // namespace skein::test
