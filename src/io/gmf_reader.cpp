// Reads GMF binary files (.meshb, .solb): rank 0 walks the keywords, then every rank decodes its even slices.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "comm/file.hpp"
#include "io/formats.hpp"
#include "io/gmf_layout.hpp"
#include "io/keywords.hpp"

namespace skein::io {
namespace {

constexpr std::int64_t kChunkBytes = std::int64_t{4} << 20;  // large enough for the disk, small enough for the cache

struct Section {
  std::int32_t code = 0;
  std::int64_t head = 0;   // byte of the keyword
  std::int64_t begin = 0;  // byte after the count
  std::int64_t end = 0;    // byte where the next keyword begins, or the end of the file
  std::int64_t count = 0;  // records; for Dimension: the dimension
};
struct Header {
  std::int32_t version = 0;
  std::int32_t swap = 0;
};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw Error(ExitCode::kInput, fmt::format("{}: {}", path, what));
}

std::string at_byte(const std::string& path, std::int64_t byte) { return fmt::format("{}, byte {}", path, byte); }

/// Small reads of single numbers, for the head of the file and of its sections.
class Cursor {
 public:
  Cursor(const InputFile& in, const std::string& path, Header header) : in_(in), path_(path), header_(header) {}
  std::int64_t at = 0;

  std::int64_t number(std::int64_t bytes) {
    if (at < 0 || bytes > in_.size() - at) {
      fail(path_, fmt::format("truncated: the file ends at byte {} where a number should begin at byte {}: copy or "
                              "write it again",
                              in_.size(), at));
    }
    std::byte b[8];
    in_.read(at, {b, static_cast<std::size_t>(bytes)});
    at += bytes;
    if (bytes == 8) return header_.swap ? gmf_load<std::int64_t, true>(b) : gmf_load<std::int64_t, false>(b);
    return header_.swap ? gmf_load<std::int32_t, true>(b) : gmf_load<std::int32_t, false>(b);
  }
  std::int64_t int32() { return number(4); }
  std::int64_t count() { return number(gmf_int_bytes(header_.version)); }
  std::int64_t position() { return number(gmf_position_bytes(header_.version)); }

 private:
  const InputFile& in_;
  const std::string& path_;
  Header header_;
};

Header read_header(const InputFile& in, const std::string& path) {
  Header h;
  Cursor c(in, path, h);
  if (in.size() < 8) fail(path, fmt::format("not a GMF binary file: it has {} bytes only", in.size()));
  const std::int64_t marker = c.int32();
  if (marker != kGmfNative && marker != kGmfSwapped) {
    fail(path,
         "not a GMF binary file (its first number is not 1 in any byte order); a text file must end in .mesh or "
         ".sol");
  }
  h.swap = marker == kGmfSwapped ? 1 : 0;
  Cursor d(in, path, h);
  d.at = 4;
  const std::int64_t version = d.int32();
  if (version < 1 || version > 4) fail(path, fmt::format("GMF version {}; known are 1 to 4", version));
  h.version = static_cast<std::int32_t>(version);
  return h;
}

/// The section at c.at; moves c to the next one, or to -1 after the last.
Section read_section(Cursor& c, const InputFile& in, const std::string& path) {
  Section s;
  s.head = c.at;
  s.code = static_cast<std::int32_t>(c.int32());
  if (s.code == static_cast<std::int32_t>(Keyword::kEnd)) {
    c.at = -1;
    return s;
  }
  const std::int64_t next = c.position();
  const KeywordInfo* k = find_keyword(s.code);
  const std::string name = k != nullptr ? std::string(k->name) : fmt::format("keyword {}", s.code);
  if (next != 0 && next <= c.at) {
    fail(path, fmt::format("damaged: {} at byte {} says that the next keyword begins at byte {}", name, s.head, next));
  }
  if (next > in.size()) {
    fail(path, fmt::format("truncated: {} at byte {} reaches to byte {}, but the file has {} bytes: copy or "
                           "write it again",
                           name, s.head, next, in.size()));
  }
  s.end = next == 0 ? in.size() : next;
  if (k != nullptr) {
    s.count = s.code == static_cast<std::int32_t>(Keyword::kDimension) ? c.int32() : c.count();
    if (s.count < 0) {
      fail(path, fmt::format("{} at byte {} has the negative count {}: the file is damaged", k->name, s.head, s.count));
    }
    refuse_elements(at_byte(path, s.head), *k, s.count);
  }
  s.begin = c.at;
  c.at = next == 0 ? -1 : next;
  return s;
}

/// The sections that are known. `others`: the names of those that are not.
std::vector<Section> read_sections(const InputFile& in, const std::string& path, Header header,
                                   std::vector<std::string>& others) {
  constexpr std::size_t kMost = 10000;  // keywords are some hundred; more means that positions lead astray
  std::vector<Section> out;
  Cursor c(in, path, header);
  c.at = 8;
  for (std::size_t n = 0; c.at >= 0; ++n) {
    if (n == kMost) fail(path, "damaged: too many keywords");
    const Section s = read_section(c, in, path);
    const KeywordInfo* k = find_keyword(s.code);
    if (k == nullptr) {
      if (s.code != static_cast<std::int32_t>(Keyword::kEnd)) others.push_back(unknown_name(s.code));
      continue;
    }
    const bool again = std::ranges::any_of(out, [&](const Section& o) { return o.code == s.code; });
    if (again) fail(path, fmt::format("{} appears a second time at byte {}", k->name, s.head));
    out.push_back(s);
  }
  return out;
}

/// A file open on all ranks, with its sections known.
struct GmfFile {
  GmfFile(const Comm& comm, const std::string& p) : path(p), in(comm, p) {
    agree(comm, [&] {
      if (!comm.is_root()) return;
      header = read_header(in, path);
      sections = read_sections(in, path, header, passed_over);
      const Section* dimension = find(Keyword::kDimension);
      if (dimension == nullptr) fail(path, "no Dimension: the file is damaged");
      require_dimension_3(path, dimension->count);
    });
    header = comm.broadcast(header);
    sections = comm.all_gather(sections);
  }
  [[nodiscard]] const Section* find(Keyword k) const {
    const auto it = std::ranges::find(sections, static_cast<std::int32_t>(k), &Section::code);
    return it == sections.end() ? nullptr : &*it;
  }
  const std::string path;
  InputFile in;
  Header header;
  std::vector<Section> sections;
  std::vector<std::string> passed_over;  // rank 0
};

/// Throws unless the records of the section lie inside it, before anything is allocated for them.
void require_room(const GmfFile& f, const Section& s, std::int64_t record_bytes) {
  const std::int64_t room = s.end - s.begin;
  if (s.count <= room / record_bytes) return;
  fail(f.path,
       fmt::format("{} at byte {} announces {} records of {} bytes, but there are {} bytes for them: the file is "
                   "truncated or damaged, write it again",
                   find_keyword(s.code)->name, s.head, s.count, record_bytes, std::max<std::int64_t>(room, 0)));
}

/// Reads records [slice.first, slice.last) in chunks and calls f(record, bytes) for each.
template <class F>
void for_records(const GmfFile& file, const Section& s, Slice slice, std::int64_t record_bytes, F&& f) {
  const std::int64_t per_chunk = std::max<std::int64_t>(1, kChunkBytes / record_bytes);
  std::vector<std::byte> buffer(static_cast<std::size_t>(std::min(per_chunk, slice.size()) * record_bytes));
  for (std::int64_t i = slice.first; i < slice.last; i += per_chunk) {
    const std::int64_t n = std::min(per_chunk, slice.last - i);
    file.in.read(s.begin + i * record_bytes, {buffer.data(), static_cast<std::size_t>(n * record_bytes)});
    for (std::int64_t k = 0; k < n; ++k) f(i + k, buffer.data() + k * record_bytes);
  }
}

template <class Layout>
void read_vertices(const Comm& comm, const GmfFile& f, const Section& s, MeshSlice& mesh) {
  using Int = typename Layout::Int;
  using Real = typename Layout::Real;
  constexpr std::int64_t kRecord = 3 * sizeof(Real) + sizeof(Int);
  const Slice slice = even_slice(s.count, comm.rank(), comm.size());
  mesh.coords.resize(static_cast<std::size_t>(slice.size()));
  mesh.vert_ref.resize(static_cast<std::size_t>(slice.size()));
  for_records(f, s, slice, kRecord, [&](std::int64_t i, const std::byte* p) {
    const auto real = [&](std::size_t k) {
      return static_cast<double>(gmf_load<Real, Layout::kSwap>(p + k * sizeof(Real)));
    };
    const Vec3 x{real(0), real(1), real(2)};
    const std::int64_t ref = gmf_load<Int, Layout::kSwap>(p + 3 * sizeof(Real));
    const auto at = [&] { return at_byte(f.path, s.begin + i * kRecord); };
    if (!is_finite(x)) throw_not_finite_coordinate(at(), i);
    if (!fits_ref(ref)) throw_bad_number(at(), {Keyword::kVertices, 4, 3, 0, {}}, i, 3, ref);
    mesh.coords[i - slice.first] = x;
    mesh.vert_ref[i - slice.first] = static_cast<std::int32_t>(ref);
  });
}

template <class Layout, class S>
void read_records(const Comm& comm, const GmfFile& f, const Section& s, const RecordSpec& spec, S& out) {
  using Int = typename Layout::Int;
  constexpr int kWidth = record_width(S{});
  constexpr std::int64_t kRecord = kWidth * sizeof(Int);
  const Slice slice = even_slice(s.count, comm.rank(), comm.size());
  resize_records(out, static_cast<std::size_t>(slice.size()));
  for_records(f, s, slice, kRecord, [&](std::int64_t i, const std::byte* p) {
    std::array<std::int64_t, static_cast<std::size_t>(kWidth)> number;
    for (int k = 0; k < kWidth; ++k) {
      const std::int64_t v = gmf_load<Int, Layout::kSwap>(p + static_cast<std::size_t>(k) * sizeof(Int));
      if (!good_number(spec, k, v)) throw_bad_number(at_byte(f.path, s.begin + i * kRecord), spec, i, k, v);
      number[k] = v;
    }
    store_record(out, static_cast<std::size_t>(i - slice.first), number.data());
  });
}

/// The kinds of the fields stand between the count and the values.
void read_field_kinds(const GmfFile& f, Section& s, FieldSlice& fields) {
  Cursor c(f.in, f.path, f.header);
  c.at = s.begin;
  const std::int64_t n = c.int32();
  require_field_count(at_byte(f.path, s.head), n);
  for (std::int64_t i = 0; i < n; ++i) {
    fields.kinds.push_back(field_kind(at_byte(f.path, s.head), i, c.int32()));
    fields.width += components(fields.kinds.back());
  }
  s.begin = c.at;
}

template <class Layout>
void read_values(const Comm& comm, const GmfFile& f, const Section& s, FieldSlice& fields) {
  using Real = typename Layout::Real;
  const auto width = static_cast<std::size_t>(fields.width);
  const Slice slice = even_slice(s.count, comm.rank(), comm.size());
  const auto record = static_cast<std::int64_t>(width * sizeof(Real));
  fields.values.resize(static_cast<std::size_t>(slice.size()) * width);
  double* out = fields.values.data();
  for_records(f, s, slice, record, [&](std::int64_t i, const std::byte* p) {
    for (std::size_t k = 0; k < width; ++k) {
      const auto v = static_cast<double>(gmf_load<Real, Layout::kSwap>(p + k * sizeof(Real)));
      if (!std::isfinite(v)) {
        throw_not_finite_value(at_byte(f.path, s.begin + i * record), i, fields, static_cast<int>(k));
      }
      *out++ = v;
    }
  });
}

void set_total(const Comm& comm, const Section* s, std::int64_t& total, std::int64_t& first) {
  total = s == nullptr ? 0 : s->count;
  first = even_slice(total, comm.rank(), comm.size()).first;
}

}  // namespace

MeshSlice read_gmf_mesh(const Comm& comm, const std::string& path) {
  const GmfFile f(comm, path);
  MeshSlice mesh;
  mesh.path = path;
  mesh.passed_over = f.passed_over;
  const Section* vertices = f.find(Keyword::kVertices);
  agree(comm, [&] {
    if (vertices == nullptr) fail(path, "no Vertices in the file: is it a solution, not a mesh?");
    require_room(f, *vertices, 3 * gmf_real_bytes(f.header.version) + gmf_int_bytes(f.header.version));
  });
  set_total(comm, vertices, mesh.total_verts, mesh.first_vert);
  for_each_section(mesh, [&](const RecordSpec& spec, auto& slice) {
    const Section* s = f.find(spec.key);
    if (s != nullptr) agree(comm, [&] { require_room(f, *s, spec.width * gmf_int_bytes(f.header.version)); });
    set_total(comm, s, slice.total, slice.first);
  });
  with_gmf_layout(f.header.version, f.header.swap != 0 ? ByteOrder::kSwapped : ByteOrder::kNative,
                  [&]<class Layout>(Layout) {
                    // section by section, so that the first bad entity is the same at any number of ranks
                    agree(comm, [&] { read_vertices<Layout>(comm, f, *vertices, mesh); });
                    for_each_section(mesh, [&](const RecordSpec& spec, auto& slice) {
                      const Section* s = f.find(spec.key);
                      if (s != nullptr) agree(comm, [&] { read_records<Layout>(comm, f, *s, spec, slice); });
                    });
                  });
  return mesh;
}

FieldSlice read_gmf_fields(const Comm& comm, const std::string& path) {
  const GmfFile f(comm, path);
  FieldSlice fields;
  fields.path = path;
  std::optional<Section> s;
  agree(comm, [&] {
    const Section* found = f.find(Keyword::kSolAtVertices);
    if (found == nullptr) fail(path, "no SolAtVertices in the file: Skein needs values at the vertices");
    s = *found;
    read_field_kinds(f, *s, fields);
    require_room(f, *s, fields.width * gmf_real_bytes(f.header.version));
  });
  set_total(comm, &*s, fields.total, fields.first);
  with_gmf_layout(f.header.version, f.header.swap != 0 ? ByteOrder::kSwapped : ByteOrder::kNative,
                  [&]<class Layout>(Layout) { agree(comm, [&] { read_values<Layout>(comm, f, *s, fields); }); });
  return fields;
}

}  // namespace skein::io
