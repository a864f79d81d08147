// Writes Medit text files (.mesh, .sol): each rank formats its slice; the places follow from the lengths.
#include <fmt/format.h>

#include <charconv>

#include "comm/file.hpp"
#include "io/formats.hpp"
#include "io/keywords.hpp"

namespace skein::io {
namespace {

/// Text that grows; numbers in the shortest form that reads back to the same bits.
class Text {
 public:
  void reserve(std::size_t bytes) { data_.reserve(bytes); }
  template <class T>
  void number(T v, char then) {
    char buffer[32];
    char* end = std::to_chars(buffer, buffer + sizeof buffer - 1, v).ptr;
    *end++ = then;
    data_.insert(data_.end(), buffer, end);
  }
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return std::as_bytes(std::span(data_)); }

 private:
  std::vector<char> data_;
};

std::span<const std::byte> bytes_of(const std::string& s) { return std::as_bytes(std::span(s.data(), s.size())); }

class Writer {
 public:
  Writer(const Comm& comm, const std::string& path) : comm_(comm), out_(comm, path) {}

  /// Collective. `head` (the same on all ranks), then the ranks' texts in rank order; fill(text) writes this rank's.
  template <class F>
  void section(const std::string& head, F&& fill) {
    Text text;
    agree(comm_, [&] { fill(text); });
    const auto mine = static_cast<std::int64_t>(text.bytes().size());
    const std::int64_t before = comm_.exclusive_sum(mine);
    const std::int64_t all = comm_.sum(mine);
    agree(comm_, [&] {
      if (comm_.is_root()) out_.write(at_, bytes_of(head));
      if (mine > 0) out_.write(at_ + static_cast<std::int64_t>(head.size()) + before, text.bytes());
    });
    at_ += static_cast<std::int64_t>(head.size()) + all;
  }
  /// Collective.
  void end() {
    section("\nEnd\n", [](Text&) {});
    out_.commit();
  }

 private:
  const Comm& comm_;
  OutputFile out_;
  std::int64_t at_ = 0;
};

constexpr const char* kHead = "MeshVersionFormatted 2\n\nDimension 3\n";

std::string section_head(Keyword key, std::int64_t total) { return fmt::format("\n{}\n{}\n", info(key).name, total); }

void write_vertices(Writer& w, const MeshSlice& mesh) {
  w.section(kHead + section_head(Keyword::kVertices, mesh.total_verts), [&](Text& t) {
    t.reserve(mesh.coords.size() * 64);
    for (std::size_t i = 0; i < mesh.coords.size(); ++i) {
      t.number(mesh.coords[i].x, ' ');
      t.number(mesh.coords[i].y, ' ');
      t.number(mesh.coords[i].z, ' ');
      t.number(mesh.vert_ref[i], '\n');
    }
  });
}

template <class S>
void write_records(Writer& w, Keyword key, const S& s) {
  if (s.total == 0) return;
  constexpr auto kWidth = static_cast<std::size_t>(record_width(S{}));
  w.section(section_head(key, s.total), [&](Text& t) {
    t.reserve(s.verts.size() * kWidth * 9);
    for (std::size_t i = 0; i < s.verts.size(); ++i) {
      std::array<std::int64_t, kWidth> number;
      load_record(s, i, number.data());
      for (std::size_t k = 0; k < kWidth; ++k) t.number(number[k], k + 1 < kWidth ? ' ' : '\n');
    }
  });
}

}  // namespace

void write_medit_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh) {
  Writer w(comm, path);
  write_vertices(w, mesh);
  for_each_section(mesh, [&](const RecordSpec& spec, const auto& s) { write_records(w, spec.key, s); });
  w.end();
}

void write_medit_fields(const Comm& comm, const std::string& path, const FieldSlice& fields) {
  Writer w(comm, path);
  std::string head = kHead + section_head(Keyword::kSolAtVertices, fields.total);
  head += fmt::format("{}", fields.kinds.size());
  for (const FieldKind k : fields.kinds) head += fmt::format(" {}", static_cast<int>(k));
  const auto width = static_cast<std::size_t>(fields.width);
  w.section(head + "\n\n", [&](Text& t) {
    t.reserve(fields.values.size() * 22);
    for (std::size_t i = 0; i < fields.values.size(); ++i) {
      t.number(fields.values[i], (i + 1) % width == 0 ? '\n' : ' ');
    }
  });
  w.end();
}

}  // namespace skein::io
