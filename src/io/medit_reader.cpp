// Reads Medit text files (.mesh, .sol).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "comm/file.hpp"
#include "io/formats.hpp"
#include "io/keywords.hpp"
#include "io/text_file.hpp"

namespace skein::io {
namespace {

/// A section with known keyword; its numbers after the head (count, and kinds of fields) begin at `begin`.
struct Section {
  const KeywordInfo* keyword = nullptr;
  std::int64_t line = 0;
  std::int64_t begin = 0, end = 0;
  std::int64_t count = 0;
};

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw Error(ExitCode::kInput, fmt::format("{}: {}", where, what));
}

struct MeditFile {
  MeditFile(const Comm& comm, const std::string& path);
  [[nodiscard]] const Section* find(Keyword k) const noexcept {
    for (const Section& s : sections) {
      if (s.keyword->code == static_cast<std::int32_t>(k)) return &s;
    }
    return nullptr;
  }
  [[nodiscard]] std::string at(const Section& s) const { return fmt::format("{}, line {}", text.path(), s.line); }

  TextFile text;
  std::vector<Section> sections;
  std::vector<std::string> passed_over;

 private:
  void add(const TextWord& w, std::int64_t head);
};

MeditFile::MeditFile(const Comm& comm, const std::string& path) : text(comm, path) {
  std::vector<std::int64_t> heads;  // the number after each word
  for (const TextWord& w : text.words()) {
    const bool wanted = w.size() > 0 && find_keyword(w.name()) != nullptr;
    heads.push_back(wanted ? text.whole_numbers(w.begin, 1).front() : TextFile::kNoNumber);
  }
  agree(comm, [&] {
    const auto& words = text.words();
    const bool begins_well = !words.empty() && words[0].begin == 0 && words[0].name() == "MeshVersionFormatted";
    if (!begins_well) fail(path, "not a Medit text file: it does not begin with MeshVersionFormatted");
    for (std::size_t i = 0; i < words.size() && words[i].name() != "End"; ++i) add(words[i], heads[i]);
    const Section* dimension = find(Keyword::kDimension);
    if (dimension == nullptr) fail(path, "no Dimension: Skein needs a file of dimension 3");
    require_dimension_3(at(*dimension), dimension->count);
  });
}

void MeditFile::add(const TextWord& w, std::int64_t head) {
  const KeywordInfo* k = find_keyword(w.name());
  if (k == nullptr) {
    const bool seen = std::ranges::find(passed_over, w.name()) != passed_over.end();
    if (!seen && w.name() != "MeshVersionFormatted") passed_over.emplace_back(w.name());
    return;
  }
  const Section s{k, w.line, w.begin + 1, w.end, head};
  for (const Section& o : sections) {
    if (o.keyword == k) fail(at(s), fmt::format("{} appears a second time", k->name));
  }
  if (head == TextFile::kNoNumber) {
    fail(at(s), fmt::format("{} must be followed by {}", k->name,
                            k->name == "Dimension" ? "the number 3" : "the number of entries"));
  }
  if (head < 0) fail(at(s), fmt::format("{} has the negative count {}", k->name, head));
  refuse_elements(at(s), *k, head);
  sections.push_back(s);
}

/// Throws unless the section has count * width numbers.
void require_size(const MeditFile& f, const Section& s, int width) {
  const std::int64_t numbers = s.end - s.begin;
  const bool fits = numbers % width == 0 && numbers / width == s.count;
  if (fits) return;
  std::string until = fmt::format("the end of the file (line {})", f.text.lines());
  for (const TextWord& w : f.text.words()) {
    if (w.begin == s.end && w.line >= s.line && w.name() != s.keyword->name) {
      until = fmt::format("'{}' in line {}", w.name(), w.line);
      break;
    }
  }
  fail(f.at(s), fmt::format("{} announces {} entries of {} numbers, but {} numbers stand before {}: {}",
                            s.keyword->name, s.count, width, numbers, until,
                            numbers / width < s.count ? "the file is cut short or the count is wrong"
                                                      : "the count or the entries are wrong"));
}

void read_vertices(const Comm& comm, const MeditFile& f, const Section& s, MeshSlice& mesh) {
  const auto number = f.text.slices<double>(s.begin, s.count, 4, [](std::int64_t i, double v, auto&& where) {
    const std::int64_t vertex = i / 4;
    if (i % 4 < 3) {
      if (!std::isfinite(v)) throw_not_finite_coordinate(where(), vertex);
    } else if (!(std::abs(v) < 9e18) || std::trunc(v) != v) {
      fail(where(), fmt::format("the reference of vertex {} is not a whole number", vertex + 1));
    } else if (!fits_ref(static_cast<std::int64_t>(v))) {
      throw_bad_number(where(), {Keyword::kVertices, 4, 3, 0, {}}, vertex, 3, static_cast<std::int64_t>(v));
    }
  });
  const auto n = static_cast<std::size_t>(even_slice(s.count, comm.rank(), comm.size()).size());
  mesh.coords.resize(n);
  mesh.vert_ref.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* p = number.data() + 4 * i;
    mesh.coords[i] = {p[0], p[1], p[2]};
    mesh.vert_ref[i] = static_cast<std::int32_t>(p[3]);
  }
}

template <class S>
void read_records(const Comm& comm, const MeditFile& f, const Section& s, const RecordSpec& spec, S& out) {
  constexpr int kWidth = record_width(S{});
  const auto number =
      f.text.slices<std::int64_t>(s.begin, s.count, kWidth, [&](std::int64_t i, std::int64_t v, auto&& where) {
        const int field = static_cast<int>(i % kWidth);
        if (!good_number(spec, field, v)) throw_bad_number(where(), spec, i / kWidth, field, v);
      });
  const auto n = static_cast<std::size_t>(even_slice(s.count, comm.rank(), comm.size()).size());
  resize_records(out, n);
  for (std::size_t i = 0; i < n; ++i) store_record(out, i, number.data() + i * kWidth);
}

void set_total(const Comm& comm, const Section* s, std::int64_t& total, std::int64_t& first) {
  total = s == nullptr ? 0 : s->count;
  first = even_slice(total, comm.rank(), comm.size()).first;
}

/// Takes the number of fields and their kinds from the first numbers of the section. Throws.
void take_field_kinds(const MeditFile& f, const std::vector<std::int64_t>& head, Section& s, FieldSlice& fields) {
  require_field_count(f.at(s), head.empty() ? 0 : head[0]);
  if (static_cast<std::int64_t>(head.size()) <= head[0]) fail(f.at(s), "the kinds of the fields are missing");
  for (std::int64_t i = 0; i < head[0]; ++i) {
    fields.kinds.push_back(field_kind(f.at(s), i, head[static_cast<std::size_t>(i) + 1]));
    fields.width += components(fields.kinds.back());
  }
  s.begin += 1 + head[0];
}

}  // namespace

MeshSlice read_medit_mesh(const Comm& comm, const std::string& path) {
  const MeditFile f(comm, path);
  MeshSlice mesh;
  mesh.path = path;
  if (comm.is_root()) mesh.passed_over = f.passed_over;
  const Section* vertices = f.find(Keyword::kVertices);
  agree(comm, [&] {
    if (vertices == nullptr) fail(path, "no Vertices in the file: is it a solution, not a mesh?");
    require_size(f, *vertices, 4);
    for_each_section(mesh, [&](const RecordSpec& spec, const auto&) {
      const Section* s = f.find(spec.key);
      if (s != nullptr) require_size(f, *s, spec.width);
    });
  });
  set_total(comm, vertices, mesh.total_verts, mesh.first_vert);
  for_each_section(
      mesh, [&](const RecordSpec& spec, auto& slice) { set_total(comm, f.find(spec.key), slice.total, slice.first); });
  read_vertices(comm, f, *vertices, mesh);
  for_each_section(mesh, [&](const RecordSpec& spec, auto& slice) {
    const Section* s = f.find(spec.key);
    if (s != nullptr) read_records(comm, f, *s, spec, slice);
  });
  return mesh;
}

FieldSlice read_medit_fields(const Comm& comm, const std::string& path) {
  const MeditFile f(comm, path);
  FieldSlice fields;
  fields.path = path;
  const Section* found = f.find(Keyword::kSolAtVertices);
  agree(comm, [&] {
    if (found == nullptr) fail(path, "no SolAtVertices in the file: Skein needs values at the vertices");
  });
  Section s = *found;
  const auto head = f.text.whole_numbers(s.begin, std::min(s.end - s.begin, kMaxFields + 1));
  agree(comm, [&] {
    take_field_kinds(f, head, s, fields);
    require_size(f, s, fields.width);
  });
  set_total(comm, &s, fields.total, fields.first);
  const int width = fields.width;
  fields.values = f.text.slices<double>(s.begin, s.count, width, [&](std::int64_t i, double v, auto&& where) {
    if (!std::isfinite(v)) throw_not_finite_value(where(), i / width, fields, static_cast<int>(i % width));
  });
  return fields;
}

}  // namespace skein::io
