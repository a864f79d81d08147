// skein::adapt(): the caller's arrays, the flow that the program has, too, and arrays again.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "adapt/method_file.hpp"
#include "api/adaptation.hpp"
#include "api/parts.hpp"
#include "api/slices.hpp"
#include "api/values.hpp"
#include "comm/guest.hpp"
#include "dist/gather_slices.hpp"
#include "report/statistics.hpp"
#include "skein/skein.hpp"
#include "solution/transfer.hpp"

namespace skein {
namespace {

MetricSource source_of(Target::Kind kind) noexcept {
  switch (kind) {
    case Target::Kind::kMetric:
      return MetricSource::kTensors;
    case Target::Kind::kSize:
      return MetricSource::kSizes;
    case Target::Kind::kOwnSizes:
      return MetricSource::kMesh;
    case Target::Kind::kField:
      break;
  }
  return MetricSource::kField;
}

const char* name_of(MetricSource source) noexcept {
  switch (source) {
    case MetricSource::kTensors:
      return "the metric";
    case MetricSource::kSizes:
      return "the sizes";
    case MetricSource::kMesh:
      return "the mesh's own sizes";
    case MetricSource::kField:
      break;
  }
  return "the field";
}

/// Collective. The method that the options name, with what they change in it.
Method choose_method(const Comm& comm, const Options& o) {
  Method m;
  if (!o.config_file.empty()) {
    m = read_method(comm, o.config_file);
  } else {
    agree(comm, [&] {
      if (!o.preset.empty()) m = find_preset(o.preset).method;
      if (!o.config.empty()) m = parse_method(o.config, "Options::config");
    });
  }
  if (o.points) m.points = *o.points == Options::Points::kCentroids ? PointCreation::kCentroids : PointCreation::kEdges;
  if (o.smoothing) {
    m.smoothing = *o.smoothing == Options::Smoothing::kSprings ? Smoothing::kSprings : Smoothing::kQuality;
  }
  return m;
}

/// freeze_patches and freeze_regions as rules.
std::vector<LocalRule> frozen_rules(const Options& o) {
  std::vector<LocalRule> rules;
  const auto add = [&](LocalRule::On on, const std::vector<std::int32_t>& refs, const char* where) {
    if (!refs.empty()) rules.push_back({on, refs, 0, 0, LocalRule::Change::kNone, where});
  };
  add(LocalRule::On::kPatches, o.freeze_patches, "Options::freeze_patches");
  add(LocalRule::On::kRegions, o.freeze_regions, "Options::freeze_regions");
  return rules;
}

AdaptationOptions to_internal(const Options& o, Target::Kind kind, const Method& method) {
  AdaptationOptions a;
  a.distribute.ridge_angle = o.ridge_angle;
  a.metric.source = source_of(kind);
  a.metric.name = name_of(a.metric.source);
  a.wanted = {o.elements, o.vertices};
  a.metric.complexity = a.wanted.given() ? complexity_for(a.wanted) : o.complexity;
  a.metric.aspect_max = o.aspect_max;
  a.metric.max_tets = o.max_elements;
  a.metric.local = frozen_rules(o);
  a.metric.h_min = o.h_min;
  a.metric.h_max = std::min(o.h_max, kNoLargestSize);
  a.metric.norm = o.norm;
  a.metric.gradation = o.gradation.value_or(usual_gradation(a.metric.source));
  a.adapt.rounds = o.rounds;
  a.adapt.threads = o.threads;
  a.adapt.method = method;
  a.adapt.surface = o.surface;
  return a;
}

/// What the command line's parser checks for the program. Comparisons are such that NaN is refused, too.
void require_in_range(const Options& o, Target::Kind kind, const Fields& fields) {
  const auto require = [](bool holds, const char* line) {
    if (!holds) throw Error(ExitCode::kUsage, line);
  };
  require(o.complexity >= 0 && std::isfinite(o.complexity), "Options::complexity must be a number >= 0");
  require(o.elements >= 0 && std::isfinite(o.elements), "Options::elements must be a number >= 0");
  require(o.vertices >= 0 && std::isfinite(o.vertices), "Options::vertices must be a number >= 0");
  require(int(o.complexity > 0) + int(o.elements > 0) + int(o.vertices > 0) <= 1,
          "only one of Options::complexity, Options::elements and Options::vertices can be given");
  require(o.aspect_max == 0 || (o.aspect_max >= 1 && std::isfinite(o.aspect_max)),
          "Options::aspect_max must be at least 1, or 0 for none");
  require(o.max_elements >= 0, "Options::max_elements must be a number >= 0");
  require(o.h_min >= 0 && std::isfinite(o.h_min), "Options::h_min must be a number >= 0");
  require(o.h_max > 0, "Options::h_max must be greater than 0");
  require(o.norm >= 1, "Options::norm must be at least 1, or infinity");
  require(o.h_min <= o.h_max, "Options::h_min is greater than Options::h_max");
  require(!o.gradation || *o.gradation == 0 || *o.gradation > 1,
          "Options::gradation must be greater than 1 (usual: 1.2 to 2), or 0 for none");
  require(kind != Target::Kind::kField || o.complexity > 0 || o.elements > 0 || o.vertices > 0,
          "Target::field needs Options::complexity (about a tenth of the tetrahedra that there shall be), elements or "
          "vertices");
  require(o.ridge_angle >= 0 && o.ridge_angle <= 180, "Options::ridge_angle must be between 0 and 180 degrees");
  require(o.rounds >= 1 && o.rounds <= 100, "Options::rounds must be between 1 and 100");
  require(o.threads >= 1 && o.threads <= 1024, "Options::threads must be between 1 and 1024");
  require(fields.width >= 0, "Fields::width must not be negative");
  const int methods = int(!o.preset.empty()) + int(!o.config.empty()) + int(!o.config_file.empty());
  require(methods <= 1, "only one of Options::preset, Options::config and Options::config_file can be given");
}

/// Collective. What must be the same on all ranks, or they would part ways.
void require_same(const Comm& comm, const Options& o, const Target& target, const Fields& fields) {
  const double mine[] = {o.complexity,
                         o.elements,
                         o.vertices,
                         o.aspect_max,
                         o.max_elements,
                         o.h_min,
                         o.h_max,
                         o.norm,
                         o.gradation.value_or(-1),
                         o.ridge_angle,
                         double(o.surface),
                         o.points ? double(static_cast<int>(*o.points)) : -1,
                         o.smoothing ? double(static_cast<int>(*o.smoothing)) : -1,
                         double(o.rounds),
                         double(o.threads),
                         double(o.return_metric),
                         double(static_cast<int>(target.kind)),
                         double(fields.width)};
  std::vector<double> least(std::begin(mine), std::end(mine)), most = least;
  comm.reduce(std::span<double>(least), Op::kMin);
  comm.reduce(std::span<double>(most), Op::kMax);
  std::string refs;
  for (const auto* list : {&o.freeze_patches, &o.freeze_regions}) {
    for (const std::int32_t r : *list) refs += fmt::format("{},", r);
    refs += ';';
  }
  const std::string texts = refs + o.preset + '\0' + o.config + '\0' + o.config_file;
  const std::string of_root = comm.broadcast(texts);
  agree(comm, [&] {
    if (least == most && texts == of_root) return;
    throw Error(ExitCode::kUsage, "options, the kind of target and the width of fields must be the same on all ranks");
  });
}

/// The run that is asked for, seen by the caller: progress, times, notes.
class Watch {
 public:
  explicit Watch(const Options& options) : progress_(options.progress), begin_(wall_time()) {}
  [[nodiscard]] PhaseObserver observer() {
    return {[this](const std::string& phase) { return tell(phase, false, 0); },
            [this](const PhaseCost& c) { return tell(c.name, true, c.elements); },
            [this](const std::string& line) {
              constexpr std::string_view kNote = "note: ";
              if (line.starts_with(kNote)) notes_.push_back(line.substr(kNote.size()));
            }};
  }
  /// Collective.
  void report(const Comm& comm, const PhaseLog& log, const MeshStatistics& s, Report& r) const {
    r.vertices = s.vertices, r.tets = s.tets, r.complexity = s.complexity;
    r.unit_edges = s.length.unit_share;
    r.quality_min = s.quality.min, r.quality_mean = s.quality.mean;
    for (const PhaseCost& c : log.phases()) r.phases.push_back({c.name, c.seconds_max});
    r.notes = notes_;
    r.seconds = comm.max(wall_time() - begin_);
  }

 private:
  [[nodiscard]] bool tell(const std::string& phase, bool finished, std::int64_t tets) const {
    return !progress_ || progress_({phase, finished, wall_time() - begin_, tets});
  }
  const std::function<bool(const Progress&)>& progress_;
  double begin_;
  std::vector<std::string> notes_;
};

/// Numbers at the vertices in one array, as they travel: the target's, then the fields'.
int width_of(Target::Kind kind) noexcept {
  return kind == Target::Kind::kMetric ? 6 : kind == Target::Kind::kOwnSizes ? 0 : 1;
}

FieldSlice slice_at(const MeshSlice& mesh, std::vector<double> values, int width, const char* name) {
  FieldSlice f;
  f.path = name, f.first_number = mesh.first_number;
  f.total = mesh.total_verts, f.first = mesh.first_vert;
  f.width = width, f.values = std::move(values);
  return f;
}

/// Collective. Slices of mesh, target and fields, checked.
AdaptationInput to_input(const Comm& comm, SlicedMesh mesh, Target target, Fields fields) {
  const MetricSource source = source_of(target.kind);
  agree(comm, [&] {
    require_values(target.values, width_of(target.kind), mesh.coords.size(), name_of(source));
    require_values(fields.values, fields.width, mesh.coords.size(), "the fields");
  });
  AdaptationInput in;
  in.mesh = to_mesh_slice(comm, std::move(mesh));
  in.carried = fields.width;
  agree(comm, [&] {
    if (in.mesh.tets.total == 0) throw Error(ExitCode::kInput, "the mesh has no tetrahedra");
    in.values = slice_at(in.mesh, std::move(target.values), width_of(target.kind), name_of(source));
    if (source != MetricSource::kMesh) {
      in.values.kinds = {source == MetricSource::kTensors ? FieldKind::kTensor : FieldKind::kScalar};
      in.values = metric_values(std::move(in.values), source);
    }
    if (fields.width == 0) return;
    const FieldSlice carried = slice_at(in.mesh, std::move(fields.values), fields.width, "the fields");
    for (const double x : carried.values) {
      if (!std::isfinite(x)) throw Error(ExitCode::kInput, "the fields: a number is not finite");
    }
    in.values = side_by_side(std::move(in.values), carried);
  });
  return in;
}

/// Collective. The same from parts. A part may have a vertex at which it has no tetrahedron.
AdaptationInput to_input(const Comm& comm, PartitionedMesh mesh, Target target, Fields fields) {
  const int width = width_of(target.kind), all = width + fields.width;
  agree(comm, [&] {
    require_values(target.values, width, mesh.coords.size(), name_of(source_of(target.kind)));
    require_values(fields.values, fields.width, mesh.coords.size(), "the fields");
    target.values = side_by_side(target.values, width, fields.values, fields.width);
  });
  SlicedParts parts = to_slices(comm, std::move(mesh), std::move(target.values), static_cast<std::size_t>(all));
  fields.values = columns(parts.values, all, width, fields.width);
  target.values = columns(parts.values, all, 0, width);
  parts.values = {};
  return to_input(comm, std::move(parts.mesh), std::move(target), std::move(fields));
}

/// The metric as the caller gets it, from its logarithm; both 6 numbers per vertex.
std::vector<double> metric_of_log(std::vector<double> values) {
  for (std::size_t i = 0; i + 6 <= values.size(); i += 6) {
    double* const d = values.data() + i;
    const SymTensor m = exp(SymTensor{d[0], d[1], d[2], d[3], d[4], d[5]});
    d[0] = m.xx, d[1] = m.xy, d[2] = m.yy, d[3] = m.xz, d[4] = m.yz, d[5] = m.zz;
  }
  return values;
}

/// Collective. The result in slices.
Adapted<SlicedMesh> sliced_result(const Comm& comm, DistMesh dist, int carried, bool metric_too) {
  Adapted<SlicedMesh> out;
  out.fields.width = carried;
  if (carried > 0) out.fields.values = field_slice(comm, dist);
  if (metric_too) out.metric = metric_of_log(to_metric_slices(comm, dist).values);
  MeshSlice slices = to_slices(comm, dist);
  dist = {};
  out.mesh = to_sliced_mesh(std::move(slices));
  return out;
}

/// Collective. The result in parts.
Adapted<PartitionedMesh> parts_result(const Comm& comm, DistMesh dist, int carried, bool metric_too) {
  Adapted<PartitionedMesh> out;
  out.fields.width = carried;
  if (carried > 0) out.fields.values = std::move(dist.mesh.fields.values);
  if (metric_too) out.metric = metric_of_log(fields_of(dist.mesh.log_metric).values);
  out.mesh = to_partitioned_mesh(comm, std::move(dist));
  return out;
}

/// Collective. The run between arrays and arrays; make_input(comm) and make_result(comm, DistMesh) are the caller's
/// convention.
template <class Mesh, class MakeInput, class MakeResult>
void run(const Comm& comm, const Options& options, const AdaptationOptions& internal, MakeInput&& make_input,
         MakeResult&& make_result, Adapted<Mesh>& out) {
  Watch watch(options);
  PhaseLog log(comm, watch.observer());
  log.start("read");
  AdaptationInput input = make_input(comm);
  apply_to_entities(comm, internal.metric.local, input.mesh);
  const std::int64_t tets_in = input.mesh.tets.total, vertices_in = input.mesh.total_verts;
  log.finish(static_cast<std::int64_t>(input.mesh.tets.verts.size()));

  DistMesh dist = run_adaptation(comm, std::move(input), internal, log);

  log.start("statistics");
  const MeshStatistics s = statistics(comm, dist, Measure::kInMetric, options.threads);
  const auto tets = static_cast<std::int64_t>(dist.mesh.tet_slots());
  log.finish(tets);
  log.start("write");
  out = make_result(comm, std::move(dist));
  log.finish(tets);
  out.report.vertices_in = vertices_in, out.report.tets_in = tets_in;
  watch.report(comm, log, s, out.report);
}

/// Collective over the caller's communicator. Checks what can be told without looking at the mesh, then runs.
template <class Mesh, class MakeInput, class MakeResult>
Adapted<Mesh> run_for(MpiHandle caller, const Options& options, const Target& target, const Fields& fields,
                      MakeInput&& make_input, MakeResult&& make_result) {
  Adapted<Mesh> out;
  run_as_guest(caller, [&](const Comm& comm) {
    agree(comm, [&] { require_in_range(options, target.kind, fields); });
    require_same(comm, options, target, fields);
    const Method method = choose_method(comm, options);
    run(comm, options, to_internal(options, target.kind, method), make_input, make_result, out);
  });
  return out;
}

}  // namespace

const char* version() noexcept { return SKEIN_VERSION; }

Adapted<SlicedMesh> adapt(MPI_Comm comm, SlicedMesh mesh, Target target, Fields fields, const Options& options) {
  const int carried = fields.width;
  return run_for<SlicedMesh>(
      MpiHandle{&comm}, options, target, fields,
      [&](const Comm& c) { return to_input(c, std::move(mesh), std::move(target), std::move(fields)); },
      [&](const Comm& c, DistMesh dist) { return sliced_result(c, std::move(dist), carried, options.return_metric); });
}

Adapted<PartitionedMesh> adapt(MPI_Comm comm, PartitionedMesh mesh, Target target, Fields fields,
                               const Options& options) {
  const int carried = fields.width;
  return run_for<PartitionedMesh>(
      MpiHandle{&comm}, options, target, fields,
      [&](const Comm& c) { return to_input(c, std::move(mesh), std::move(target), std::move(fields)); },
      [&](const Comm& c, DistMesh dist) { return parts_result(c, std::move(dist), carried, options.return_metric); });
}

}  // namespace skein
