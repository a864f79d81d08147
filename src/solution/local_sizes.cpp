// Rules by patch and region: bounds at vertices, required entities.
#include "solution/local_sizes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "comm/halo.hpp"

namespace skein {
namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();

bool is_on(const LocalRule& r, LocalRule::On what) noexcept { return r.on == what || r.on == LocalRule::On::kBoth; }
bool names(const LocalRule& r, std::int32_t ref) noexcept { return std::ranges::find(r.refs, ref) != r.refs.end(); }

/// Calls f(v) for the vertices of the faces and tetrahedra here that the rule names.
template <class F>
void for_verts(const TetMesh& m, const LocalRule& r, F&& f) {
  std::vector<char> patch(m.patch_ref.size());
  for (std::size_t p = 0; p < patch.size(); ++p) {
    patch[p] = is_on(r, LocalRule::On::kPatches) && names(r, m.patch_ref[p]) ? 1 : 0;
  }
  const bool regions = is_on(r, LocalRule::On::kRegions);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    if (regions && names(r, m.tet_ref[t])) {
      for (const VertId v : m.tet2vert[t]) f(v);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const FaceTag tag = m.face_tag[t][k];
      if (tag == 0 || patch[static_cast<std::size_t>(tag_patch(tag))] == 0) continue;
      for (const VertId v : m.verts(make_face(t, k))) f(v);
    }
  }
}

/// Collective. Which references of the rule the mesh has, as a triangle's or a tetrahedron's.
std::vector<std::int32_t> found_refs(const Comm& comm, const LocalRule& r, const MeshSlice& mesh) {
  std::vector<std::int32_t> found(r.refs.size(), 0);
  const auto look = [&](const std::vector<std::int32_t>& refs) {
    for (const std::int32_t ref : refs) {
      const auto at = std::ranges::find(r.refs, ref) - r.refs.begin();
      if (at < std::ssize(r.refs)) found[static_cast<std::size_t>(at)] = 1;
    }
  };
  if (is_on(r, LocalRule::On::kPatches)) look(mesh.triangles.ref);
  if (is_on(r, LocalRule::On::kRegions)) look(mesh.tets.ref);
  comm.reduce(std::span<std::int32_t>(found), Op::kMax);
  return found;
}

/// Adds the numbers of the entities that a rule freezes to this rank's slice of the list.
template <std::size_t N>
void freeze(const std::vector<LocalRule>& rules, LocalRule::On what, const EntitySlice<N>& s, VertexListSlice& list) {
  for (std::size_t i = 0; i < s.ref.size(); ++i) {
    const bool frozen = std::ranges::any_of(rules, [&](const LocalRule& r) {
      return r.change == LocalRule::Change::kNone && is_on(r, what) && names(r, s.ref[i]);
    });
    if (frozen) list.verts.push_back(GlobalId{s.first + static_cast<std::int64_t>(i)});
  }
}

}  // namespace

LocalBounds::LocalBounds(const Comm& comm, const DistMesh& dist, const std::vector<LocalRule>& rules) {
  const bool any = std::ranges::any_of(rules, [](const LocalRule& r) { return r.h_min > 0 || r.h_max > 0; });
  if (!any) return;
  low_.assign(dist.mesh.vert_slots(), kNone);
  high_ = low_;
  for (const LocalRule& r : rules) {
    const double low = r.h_max > 0 ? -2 * std::log(r.h_max) : kNone;
    const double high = r.h_min > 0 ? -2 * std::log(r.h_min) : kNone;
    for_verts(dist.mesh, r, [&](VertId v) {
      low_[idx(v)] = std::max(low_[idx(v)], low);
      high_[idx(v)] = std::max(high_[idx(v)], high);
    });
  }
  const Halo halo(comm, dist.sharing);
  halo.max<double>(low_);
  halo.max<double>(high_);
}

void LocalBounds::apply(std::span<SymTensor> log_metric) const {
  for (std::size_t v = 0; v < low_.size(); ++v) {
    if (low_[v] == kNone && high_[v] == kNone) continue;
    Eigen e = eigen(log_metric[v]);
    for (double& value : e.value) {
      if (high_[v] != kNone) value = std::min(value, high_[v]);
      value = std::max(value, low_[v]);
    }
    log_metric[v] = e.value[0] == e.value[2] ? isotropic(e.value[0]) : compose(e);
  }
}

void apply_to_entities(const Comm& comm, const std::vector<LocalRule>& rules, MeshSlice& mesh) {
  for (const LocalRule& r : rules) {
    const std::vector<std::int32_t> found = found_refs(comm, r, mesh);
    agree(comm, [&] {
      const auto missing = std::ranges::find(found, 0);
      if (missing == found.end()) return;
      const char* kind = r.on == LocalRule::On::kPatches   ? "patch"
                         : r.on == LocalRule::On::kRegions ? "region"
                                                           : "patch or region";
      throw Error(ExitCode::kInput, fmt::format("{}: {} has no {} {}", r.where, mesh.path, kind,
                                                r.refs[static_cast<std::size_t>(missing - found.begin())]));
    });
  }
  freeze(rules, LocalRule::On::kPatches, mesh.triangles, mesh.required_triangles);
  freeze(rules, LocalRule::On::kRegions, mesh.tets, mesh.required_tets);
  for (VertexListSlice* list : {&mesh.required_triangles, &mesh.required_tets}) {
    const auto mine = static_cast<std::int64_t>(list->verts.size());
    list->first = comm.exclusive_sum(mine);
    list->total = comm.sum(mine);
  }
}

}  // namespace skein
