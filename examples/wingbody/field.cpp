// wingbody_field MESH OUT.solb: an analytic, flow-like scalar at the vertices of a mesh round the wing-body.
//
// Not a flow solution: a formula shaped like a Mach number, with the features that an adapter has to find: a detached
// bow shock, a lambda shock on the wing's upper side and a wake sheet behind the trailing edge. Every rank evaluates
// the slice of vertices that it has read.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "comm/comm.hpp"
#include "io/mesh_io.hpp"

namespace {

using skein::Vec3;

// The wing's planform, as in geometry/make_surface.py; lengths in units of the geometry.
constexpr double kSpan = 15.0, kRootChord = 7.0, kTaper = 0.3;
constexpr double kRootX = 10.0, kRootZ = -0.60;
constexpr double kTanSweep = 0.531709, kTanDihedral = 0.0699268;  // 28 and 4 degrees

/// 0 well below zero, 1 well above, a hyperbolic tangent of the given half width between.
double step(double d, double width) { return 0.5 * (1 + std::tanh(d / width)); }
double bell(double d, double width) { return std::exp(-(d / width) * (d / width)); }

/// Where a point is with respect to the wing.
struct WingPlace {
  double s;    ///< along the chord: 0 leading edge, 1 trailing edge
  double h;    ///< above the chord plane
  double eta;  ///< along the half span: 0 symmetry plane, 1 tip
  double chord;
};
WingPlace wing_place(Vec3 p) {
  const double y = std::clamp(p.y, 0.0, 1.2 * kSpan);
  const double chord = kRootChord * (1 + (kTaper - 1) * y / kSpan);
  return {(p.x - kRootX - y * kTanSweep) / chord, p.z - kRootZ - y * kTanDihedral, p.y / kSpan, chord};
}

/// Supersonic ahead of a hyperboloid that stands off the nose; the jump fades away from the body.
double bow_shock(Vec3 p) {
  constexpr double kStandOff = 1.1, kCurvature = 3.0, kSlope = 1.1, kWidth = 0.10;
  const double r2 = p.y * p.y + p.z * p.z;
  const double root = std::sqrt(1 + r2 / (kCurvature * kCurvature));
  const double shock_x = -kStandOff + kSlope * kCurvature * (root - 1);
  const double slope = kSlope * std::sqrt(r2) / (kCurvature * root);
  const double distance = (p.x - shock_x) / std::sqrt(1 + slope * slope);
  const double jump = 0.55 * std::exp(-r2 / (22.0 * 22.0));
  return -jump * step(distance, kWidth);
}

/// A supersonic pocket over the wing that ends in two shocks: the front one runs from the root's leading edge to the
/// rear one and merges with it at 80 % of the half span.
double lambda_shock(const WingPlace& w) {
  constexpr double kWidth = 0.035, kMerge = 0.8;
  const double rear_s = 0.62 - 0.05 * w.eta;
  const double gap = 0.44 * (kMerge - w.eta) / kMerge;
  const double smooth_gap = 0.5 * (gap + std::sqrt(gap * gap + 0.02 * 0.02));  // max(gap, 0) without its kink
  const double lean = 0.12 * std::max(w.h, 0.0) / w.chord;                     // shocks lean back with height
  const double to_normal = 0.92 * w.chord;
  const double rear = step((rear_s + lean - w.s) * to_normal, kWidth);
  const double front = step((rear_s - smooth_gap + lean - w.s) * to_normal, kWidth);
  const double pocket = bell(std::max(w.h, 0.0), 0.38 * w.chord) * step(w.h + 0.01 * w.chord, 0.02 * w.chord) *
                        step(w.s - 0.07, 0.05) * step(0.985 - w.eta, 0.02);
  return pocket * (0.28 * rear + 0.22 * front);
}

/// Slower fluid in a sheet that leaves the trailing edge and widens downstream.
double wake(Vec3 p, const WingPlace& w) {
  const double behind = p.x - kRootX - kTanSweep * std::clamp(p.y, 0.0, kSpan) - w.chord;
  const double length = std::max(behind, 0.0);
  return -0.30 * step(behind, 0.12) * bell(w.h, 0.07 + 0.012 * length) * std::exp(-length / 14.0) *
         step(0.99 - w.eta, 0.015);
}

double mach_like(Vec3 p) {
  const WingPlace w = wing_place(p);
  const double stagnation = -0.5 * bell(skein::norm(p), 0.9);
  return 1.40 + bow_shock(p) + lambda_shock(w) + wake(p, w) + stagnation;
}

int run(const skein::Comm& comm, const std::string& mesh_path, const std::string& out_path) {
  const skein::MeshSlice mesh = skein::read_mesh(comm, mesh_path);
  skein::FieldSlice field;
  field.path = out_path;
  field.total = mesh.total_verts;
  field.first = mesh.first_vert;
  field.kinds = {skein::FieldKind::kScalar};
  field.width = 1;
  field.values.reserve(mesh.coords.size());
  for (const Vec3& p : mesh.coords) field.values.push_back(mach_like(p));
  skein::write_fields(comm, out_path, field);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const skein::Environment environment(argc, argv);
  const skein::Comm comm = skein::Comm::world();
  if (argc != 3) {
    if (comm.is_root()) std::fprintf(stderr, "usage: wingbody_field MESH OUT.solb\n");
    return static_cast<int>(skein::ExitCode::kUsage);
  }
  try {
    return run(comm, argv[1], argv[2]);
  } catch (const skein::Error& e) {
    if (comm.is_root()) std::fprintf(stderr, "wingbody_field: %s\n", e.what());
    return static_cast<int>(e.code());
  }
}
