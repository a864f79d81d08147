// Metrics, sizes and solutions as they are given: checked, and as logarithms.
#include "solution/metric_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/tensor.hpp"

namespace skein {
namespace {

constexpr double kRoundedZero = 1e-14;  ///< eigenvalues this small against the largest may be negative zeros
constexpr double kLogOfNoLimit = -700;  ///< of an eigenvalue of zero: a size of 1e152
constexpr double kLeastShare = -60;     ///< logarithms this far below the largest do not matter where two metrics meet

void put(const SymTensor& l, double* out) noexcept {
  out[0] = l.xx, out[1] = l.xy, out[2] = l.yy, out[3] = l.xz, out[4] = l.yz, out[5] = l.zz;
}

/// The logarithm of the metric with this edge length in all directions.
SymTensor log_of_size(double h) noexcept { return isotropic(-2 * std::log(h)); }

/// For messages.
std::int64_t vertex_number(const FieldSlice& f, std::size_t i) noexcept {
  return f.first + static_cast<std::int64_t>(i) + f.first_number;
}

SymTensor checked_log(const SymTensor& m, const FieldSlice& f, std::size_t i) {
  if (!is_finite(m)) {
    throw Error(ExitCode::kInput,
                fmt::format("{}: the metric at vertex {} is not finite", f.path, vertex_number(f, i)));
  }
  if (!is_positive_definite(m)) {
    Eigen e = eigen(m);
    if (e.value[0] >= -kRoundedZero * std::max(e.value[2], 0.0)) {
      for (double& value : e.value) value = value > 0 ? std::log(value) : kLogOfNoLimit;
      return compose(e);
    }
    throw Error(ExitCode::kInput,
                fmt::format("{}: the metric at vertex {} is not positive: eigenvalues {:.6g}, {:.6g}, {:.6g}", f.path,
                            vertex_number(f, i), e.value[0], e.value[1], e.value[2]));
  }
  return log(m);
}

FieldSlice log_of_tensors(FieldSlice f) {
  for (std::size_t i = 0; i < f.values.size() / 6; ++i) {
    double* v = f.values.data() + 6 * i;
    put(checked_log({v[0], v[1], v[2], v[3], v[4], v[5]}, f, i), v);
  }
  return f;
}

FieldSlice log_of_sizes(const FieldSlice& sizes) {
  FieldSlice f;
  f.path = sizes.path, f.first_number = sizes.first_number, f.total = sizes.total, f.first = sizes.first;
  f.kinds = {FieldKind::kTensor}, f.width = 6;
  f.values.resize(6 * sizes.values.size());
  for (std::size_t i = 0; i < sizes.values.size(); ++i) {
    const double h = sizes.values[i];
    if (!(h > 0) || !std::isfinite(h)) {
      throw Error(ExitCode::kInput, fmt::format("{}: the size at vertex {} is {:.6g}; sizes must be greater than zero",
                                                f.path, vertex_number(f, i), h));
    }
    put(log_of_size(h), f.values.data() + 6 * i);
  }
  return f;
}

FieldSlice finite(FieldSlice f) {
  for (std::size_t i = 0; i < f.values.size(); ++i) {
    if (std::isfinite(f.values[i])) continue;
    throw Error(ExitCode::kInput, fmt::format("{}: the value at vertex {} is not finite", f.path, vertex_number(f, i)));
  }
  return f;
}

SymTensor get(const double* v) noexcept { return {v[0], v[1], v[2], v[3], v[4], v[5]}; }

bool is_isotropic(const SymTensor& l) noexcept {
  return l.xy == 0 && l.xz == 0 && l.yz == 0 && l.xx == l.yy && l.yy == l.zz;
}

}  // namespace

SymTensor strictest(const SymTensor& a, const SymTensor& b) {
  if (is_isotropic(a)) return at_least(b, a.xx);
  if (is_isotropic(b)) return at_least(a, b.xx);
  Eigen e = eigen(a), f = eigen(b);
  const double top = std::max(e.value[2], f.value[2]);
  for (Eigen* x : {&e, &f}) {
    for (double& value : x->value) value = std::max(value, top + kLeastShare) - top;
  }
  return log(intersect(exp(compose(e)), exp(compose(f)))) + isotropic(top);
}

SymTensor at_least(const SymTensor& l, double log_eigenvalue) {
  if (is_isotropic(l)) return isotropic(std::max(l.xx, log_eigenvalue));
  Eigen e = eigen(l);
  if (e.value[0] >= log_eigenvalue) return l;
  for (double& value : e.value) value = std::max(value, log_eigenvalue);
  return compose(e);
}

FieldSlice strictest(FieldSlice a, const FieldSlice& b) {
  for (std::size_t i = 0; i + 6 <= a.values.size(); i += 6) {
    put(strictest(get(a.values.data() + i), get(b.values.data() + i)), a.values.data() + i);
  }
  return a;
}

FieldSlice metric_values(FieldSlice given, MetricSource source) {
  switch (source) {
    case MetricSource::kTensors:
      return log_of_tensors(std::move(given));
    case MetricSource::kSizes:
      return log_of_sizes(given);
    case MetricSource::kField:
    case MetricSource::kMesh:
      return finite(std::move(given));
  }
  return given;
}

}  // namespace skein
