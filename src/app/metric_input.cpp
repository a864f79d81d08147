// What the mesh is adapted to, from the command line and its files.
#include "app/metric_input.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "app/files.hpp"
#include "app/numbers.hpp"
#include "generate/sources_file.hpp"
#include "io/mesh_io.hpp"
#include "solution/local_file.hpp"

namespace skein::app {
namespace {

constexpr double kNoSize = 1e100;  ///< of the metric itself, where sources alone say the sizes

/// The whole word as a number.
template <class T>
std::optional<T> number_of(const std::string& word) {
  T value{};
  const char* const end = word.data() + word.size();
  const auto [at, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && at == end && !word.empty() ? std::optional(value) : std::nullopt;
}

[[noreturn]] void refuse(const std::string& line) { throw Error(ExitCode::kInput, line); }

/// The n numbers per vertex that begin at `first`.
FieldSlice one_field(const FieldSlice& f, std::size_t index) {
  int first = 0;
  for (std::size_t i = 0; i < index; ++i) first += components(f.kinds[i]);
  FieldSlice out;
  out.path = f.path, out.first_number = f.first_number, out.total = f.total, out.first = f.first;
  out.kinds = {f.kinds[index]};
  out.width = components(f.kinds[index]);
  const auto all = static_cast<std::size_t>(f.width), width = static_cast<std::size_t>(out.width);
  for (std::size_t v = 0; v + all <= f.values.size(); v += all) {
    const double* from = f.values.data() + v + static_cast<std::size_t>(first);
    out.values.insert(out.values.end(), from, from + width);
  }
  return out;
}

/// The field that is meant: the one with the number, or else the only one of this kind. Throws.
std::size_t choose(const FieldSlice& f, const FieldPath& path, FieldKind want) {
  if (path.number) {
    if (*path.number < 1 || *path.number > std::ssize(f.kinds))
      refuse(fmt::format("{}: there is no field {}; the file has {}", f.path, *path.number, f.kinds.size()));
    return static_cast<std::size_t>(*path.number) - 1;
  }
  std::vector<std::size_t> fit;
  for (std::size_t i = 0; i < f.kinds.size(); ++i) {
    if (f.kinds[i] == want) fit.push_back(i);
  }
  if (f.kinds.size() == 1 || fit.size() == 1) return fit.size() == 1 ? fit[0] : 0;
  refuse(fmt::format("{}: {} fields at the vertices, {} of the wanted kind; name one by its number, as {}:1", f.path,
                     f.kinds.size(), fit.size(), f.path));
}

/// The field of the file that is wanted, with a value for every vertex. Throws.
FieldSlice fitting(const FieldSlice& f, const FieldPath& path, const MeshSlice& mesh, FieldKind want) {
  FieldSlice one = one_field(f, choose(f, path, want));
  if (one.kinds[0] != want) {
    const char* advice = want == FieldKind::kScalar ? "use --metric for symmetric tensors"
                                                    : "use --size for sizes, or --field for a solution";
    refuse(fmt::format("{}: {} number(s) per vertex, but {} wanted; {}", f.path, one.width,
                       want == FieldKind::kScalar ? "one is" : "a symmetric tensor (6) is", advice));
  }
  if (f.total != mesh.total_verts) {
    refuse(fmt::format("{}: {} values for the {} vertices of {}; give the one of this mesh", f.path, f.total,
                       mesh.total_verts, mesh.path));
  }
  return one;
}

/// The same size at all vertices.
FieldSlice uniform(const MeshSlice& mesh, double size, const std::string& name) {
  FieldSlice f;
  f.path = name, f.first_number = mesh.first_number;
  f.total = mesh.total_verts, f.first = mesh.first_vert;
  f.kinds = {FieldKind::kScalar}, f.width = 1;
  f.values.assign(mesh.coords.size(), size);
  return f;
}

/// Collective. One of the words of --metric, --size or --field.
FieldSlice read_one(const Comm& comm, const MeshSlice& mesh, const std::string& word, MetricSource source) {
  const std::optional<double> size = source == MetricSource::kSizes ? number_of<double>(word) : std::nullopt;
  const FieldPath path = to_field_path(word);
  FieldSlice f = size ? uniform(mesh, *size, "--size") : read_fields(comm, path.file);
  agree(comm, [&] {
    const FieldKind want = source == MetricSource::kTensors ? FieldKind::kTensor : FieldKind::kScalar;
    f = metric_values(size ? std::move(f) : fitting(f, path, mesh, want), source);
  });
  return f;
}

/// R, patch:R or region:R of --freeze-ref.
LocalRule to_rule(const std::string& word) {
  LocalRule r;
  r.change = LocalRule::Change::kNone;
  r.where = "--freeze-ref";
  const std::size_t colon = word.find(':');
  const std::string kind = colon == std::string::npos ? "" : word.substr(0, colon);
  r.on = kind.empty() ? LocalRule::On::kBoth : kind == "patch" ? LocalRule::On::kPatches : LocalRule::On::kRegions;
  const auto ref = number_of<std::int32_t>(word.substr(colon == std::string::npos ? 0 : colon + 1));
  if (!ref || !(kind.empty() || kind == "patch" || kind == "region"))
    throw Error(ExitCode::kUsage,
                fmt::format("adapt: --freeze-ref {}: give R, patch:R or region:R, R a reference", word));
  r.refs = {*ref};
  return r;
}

}  // namespace

FieldPath to_field_path(const std::string& word) {
  std::error_code e;
  const std::size_t colon = word.rfind(':');
  if (colon == std::string::npos || std::filesystem::exists(word, e)) return {word, {}};
  const std::optional<int> n = number_of<int>(word.substr(colon + 1));
  return n ? FieldPath{word.substr(0, colon), n} : FieldPath{word, {}};
}

MetricSource MetricOptions::source() const noexcept {
  if (!metric.empty()) return MetricSource::kTensors;
  if (!field.empty()) return MetricSource::kField;
  return optim ? MetricSource::kMesh : MetricSource::kSizes;
}

const std::vector<std::string>& MetricOptions::words() const noexcept {
  return !metric.empty() ? metric : !field.empty() ? field : size;
}

std::vector<std::string> MetricOptions::files() const {
  std::vector<std::string> out;
  for (const std::string& word : words()) {
    if (!field.empty() || !number_of<double>(word)) out.push_back(to_field_path(word).file);
  }
  for (const std::string* more : {&sources, &local}) {
    if (!more->empty()) out.push_back(*more);
  }
  return out;
}

void add_metric_options(CLI::App& verb, MetricOptions& o) {
  auto* metric = verb.add_option("--metric", o.metric, "metric: a symmetric tensor per vertex (.sol, .solb)")
                     ->allow_extra_args(false);
  verb.add_option("--size", o.size, "wanted edge length: a number, or one per vertex (.sol, .solb)")
      ->allow_extra_args(false)
      ->excludes(metric);
  verb.add_option("--complexity", o.numbers.complexity,
                  "scale the metric to this complexity: the volume of the mesh as the metric measures it; about 11 "
                  "tetrahedra per unit")
      ->check(positive());
}

void add_adapt_metric_options(CLI::App& verb, MetricOptions& o) {
  verb.add_option("--field", o.field, "solution, a scalar per vertex: adapt to its second derivatives")
      ->allow_extra_args(false)
      ->excludes("--metric")
      ->excludes("--size");
  verb.add_flag("--optim", o.optim, "keep the mesh's own sizes, and improve it")
      ->excludes("--metric")
      ->excludes("--size")
      ->excludes("--field");
  auto* complexity = verb.get_option("--complexity");
  auto* elements = verb.add_option("--elements", o.wanted.elements, "scale the metric to so many tetrahedra")
                       ->check(positive())
                       ->excludes(complexity);
  verb.add_option("--vertices", o.wanted.vertices, "scale the metric to so many vertices")
      ->check(positive())
      ->excludes(complexity)
      ->excludes(elements);
  verb.add_option("--norm", o.numbers.norm, "with --field: the error's norm, 1, 2, 4 ... or inf")
      ->check(CLI::Range(1.0, std::numeric_limits<double>::infinity()));
  verb.add_option("--hmin", o.numbers.h_min, "smallest edge length")->check(positive());
  verb.add_option("--hmax", o.numbers.h_max, "largest edge length")->check(positive());
  verb.add_option("--aspect-max", o.numbers.aspect_max, "largest over smallest edge length at a vertex, at least 1")
      ->check(CLI::Range(1.0, 1e12));
  verb.add_option("--gradation", o.gradation,
                  "sizes grow at most by this factor per edge (> 1; 0: no bound); 1.3 with --size, else 0");
  verb.add_option("--max-elements", o.numbers.max_tets,
                  "refuse sizes that ask for more tetrahedra (else: for more than there is memory for)")
      ->check(positive());
  verb.add_option("--sources", o.sources, "spacing sources (TOML): no size above theirs");
  verb.add_option("--local", o.local, "sizes, bounds and freezing by patch and region (TOML)");
  verb.add_option("--freeze-ref", o.freeze, "patches and regions that stay as they are: R,... or patch:R, region:R")
      ->delimiter(',')
      ->type_name("R,...")
      ->allow_extra_args(false);
}

void require_metric(const Comm& comm, const MetricOptions& o) {
  agree(comm, [&] {
    const auto fail = [](const char* line) { throw Error(ExitCode::kUsage, line); };
    const MetricPolicy& m = o.numbers;
    if (!o.given())
      fail("adapt: one of --metric, --size, --field, --optim, --sources is needed; see: skein adapt --help");
    if (!o.field.empty() && m.complexity <= 0 && !o.wanted.given())
      fail("adapt: --field needs --complexity, --elements or --vertices, which tell how fine the mesh shall be");
    if (m.h_min > m.h_max) fail("adapt: --hmin is greater than --hmax");
    if (o.gradation && *o.gradation != 0 && !(*o.gradation > 1))
      fail("adapt: --gradation must be greater than 1 (usual: 1.2 to 2), or 0 for none");
    for (const std::string& word : o.size) {
      const auto size = number_of<double>(word);
      if (size && (!(*size > 0) || !std::isfinite(*size))) fail("adapt: --size must be greater than 0, or a file");
    }
  });
  for (const std::string& path : o.files()) {
    const bool toml = path == o.sources || path == o.local;
    require_input(comm, path, toml ? std::initializer_list<const char*>{} : kFields);
  }
}

MetricPolicy read_policy(const Comm& comm, const MetricOptions& o) {
  MetricPolicy p = o.numbers;
  p.source = o.source();
  if (o.wanted.given()) p.complexity = complexity_for(o.wanted);
  p.gradation = o.gradation.value_or(usual_gradation(p.source));
  p.name = !o.words().empty() ? o.words()[0] : p.source == MetricSource::kMesh ? "the mesh's own sizes" : o.sources;
  if (number_of<double>(p.name)) p.name = "--size " + p.name;
  if (!o.sources.empty()) p.sources = read_sources(comm, o.sources);
  if (!o.local.empty()) p.local = read_local(comm, o.local);
  agree(comm, [&] {
    for (const std::string& word : o.freeze) p.local.push_back(to_rule(word));
  });
  return p;
}

FieldSlice read_metric(const Comm& comm, const MeshSlice& mesh, const MetricOptions& o) {
  const MetricSource source = o.source();
  FieldSlice all;
  all.total = mesh.total_verts, all.first = mesh.first_vert, all.first_number = mesh.first_number;
  all.path = mesh.path;
  if (source == MetricSource::kMesh) return all;
  if (o.words().empty()) return metric_values(uniform(mesh, kNoSize, o.sources), source);
  for (const std::string& word : o.words()) {
    FieldSlice one = read_one(comm, mesh, word, source);
    all = all.width == 0                   ? std::move(one)
          : source == MetricSource::kField ? side_by_side(std::move(all), one)
                                           : strictest(std::move(all), one);
  }
  return all;
}

}  // namespace skein::app
