// Writes GMF binary files (.meshb, .solb): every position follows from the totals, so all ranks write at once.
#include <fmt/format.h>

#include <algorithm>

#include "comm/file.hpp"
#include "io/formats.hpp"
#include "io/gmf_layout.hpp"
#include "io/keywords.hpp"

namespace skein::io {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{8} << 20;

/// Bytes of a keyword with the position of the next one, in a file of this version.
constexpr std::int64_t key_bytes(int version) noexcept { return 4 + gmf_position_bytes(version); }

/// Places the sections one behind the other; every rank computes the same positions, rank 0 writes the heads.
class Writer {
 public:
  Writer(const Comm& comm, const std::string& path, int version)
      : comm_(comm), out_(comm, path), version_(version), int_bytes_(gmf_int_bytes(version)) {
    put32(kGmfNative);
    put32(version);
    head(Keyword::kDimension, 4);
    put32(3);  // goes out with the head of the first section: a constructor must not fail on one rank alone
  }

  /// Not collective. A section of `total` records, of which this rank has `n` from `first`; encode(i, bytes) fills one.
  template <class F>
  void section(Keyword key, const std::vector<std::int32_t>& extra, std::int64_t total, std::int64_t first,
               std::size_t n, std::size_t record_bytes, F&& encode) {
    const auto size = static_cast<std::int64_t>(record_bytes);
    head(key, int_bytes_ + 4 * static_cast<std::int64_t>(extra.size()) + total * size);
    version_ >= 4 ? put64(total) : put32(static_cast<std::int32_t>(total));
    for (const std::int32_t v : extra) put32(v);
    flush();
    const std::size_t per_chunk = std::max<std::size_t>(1, kChunkBytes / record_bytes);
    std::vector<std::byte> buffer(std::min(per_chunk, n) * record_bytes);
    for (std::size_t i = 0; i < n; i += per_chunk) {
      const std::size_t m = std::min(per_chunk, n - i);
      for (std::size_t k = 0; k < m; ++k) encode(i + k, buffer.data() + k * record_bytes);
      out_.write(at_ + (first + static_cast<std::int64_t>(i)) * size, {buffer.data(), m * record_bytes});
    }
    at_ += total * size;
  }
  /// Not collective.
  void end() {
    put32(static_cast<std::int32_t>(Keyword::kEnd));
    put_position(0);
    flush();
  }
  /// Collective.
  void commit() { out_.commit(); }

 private:
  void put32(std::int32_t v) { put(v); }
  void put64(std::int64_t v) { put(v); }
  void put_position(std::int64_t v) { version_ >= 3 ? put64(v) : put32(static_cast<std::int32_t>(v)); }
  template <class T>
  void put(T v) {
    head_.resize(head_.size() + sizeof v);
    gmf_store(head_.data() + head_.size() - sizeof v, v);
  }
  void head(Keyword key, std::int64_t body_bytes) {
    put32(static_cast<std::int32_t>(key));
    put_position(at_ + static_cast<std::int64_t>(head_.size()) + gmf_position_bytes(version_) + body_bytes);
  }
  void flush() {
    if (comm_.is_root()) out_.write(at_, head_);
    at_ += static_cast<std::int64_t>(head_.size());
    head_.clear();
  }

  const Comm& comm_;
  OutputFile out_;
  const int version_;
  const std::int64_t int_bytes_;
  std::int64_t at_ = 0;
  std::vector<std::byte> head_;
};

template <class Int>
void write_vertices(Writer& w, const MeshSlice& mesh) {
  w.section(Keyword::kVertices, {}, mesh.total_verts, mesh.first_vert, mesh.coords.size(), 24 + sizeof(Int),
            [&](std::size_t i, std::byte* p) {
              gmf_store(p, mesh.coords[i].x);
              gmf_store(p + 8, mesh.coords[i].y);
              gmf_store(p + 16, mesh.coords[i].z);
              gmf_store(p + 24, static_cast<Int>(mesh.vert_ref[i]));
            });
}

template <class Int, class S>
void write_records(Writer& w, Keyword key, const S& s) {
  constexpr int kWidth = record_width(S{});
  if (s.total == 0) return;
  w.section(key, {}, s.total, s.first, s.verts.size(), kWidth * sizeof(Int), [&](std::size_t i, std::byte* p) {
    std::array<std::int64_t, static_cast<std::size_t>(kWidth)> number;
    load_record(s, i, number.data());
    for (const std::int64_t v : number) {
      gmf_store(p, static_cast<Int>(v));
      p += sizeof(Int);
    }
  });
}

template <class Int>
void write_sections(Writer& w, const MeshSlice& mesh) {
  write_vertices<Int>(w, mesh);
  for_each_section(mesh, [&](const RecordSpec& spec, const auto& s) { write_records<Int>(w, spec.key, s); });
}

/// What decides on the version of a file.
struct Extent {
  std::int64_t largest = 0;  ///< of the numbers in it
  std::int64_t bytes = 0;    ///< in version 2
};

Extent extent_of(const MeshSlice& mesh) {
  constexpr std::int64_t kHead = key_bytes(2) + 4, kVertex = 28;
  Extent e{mesh.total_verts, 8 + 2 * kHead + key_bytes(2) + mesh.total_verts * kVertex};
  for_each_section(mesh, [&](const RecordSpec& spec, const auto& s) {
    e.largest = std::max(e.largest, s.total);
    e.bytes += kHead + 4 * spec.width * s.total;
  });
  return e;
}

Extent extent_of(const FieldSlice& f) {
  constexpr std::int64_t kHead = key_bytes(2) + 4;
  const auto kinds = 4 * (1 + static_cast<std::int64_t>(f.kinds.size()));
  return {f.total, 8 + 2 * kHead + kinds + key_bytes(2) + f.total * f.width * 8};
}

/// Collective. The version asked for, or the lowest that holds the file.
int choose_version(const Comm& comm, const std::string& path, GmfVersion asked, const Extent& extent) {
  const int least = gmf_version_for(extent.largest, extent.bytes);
  if (asked == GmfVersion::kLowest) return least;
  agree(comm, [&] {
    if (static_cast<int>(asked) >= least) return;
    throw Error(
        ExitCode::kOutput,
        fmt::format("{}: GMF version {} does not hold {} entities in {:.3g} GB; version {} does (--format-version)",
                    path, static_cast<int>(asked), extent.largest, 1e-9 * static_cast<double>(extent.bytes), least));
  });
  return static_cast<int>(asked);
}

}  // namespace

int gmf_version_for(std::int64_t largest, std::int64_t bytes) noexcept {
  if (largest > INT32_MAX) return 4;
  return bytes > INT32_MAX ? 3 : 2;
}

void write_gmf_mesh(const Comm& comm, const std::string& path, const MeshSlice& mesh, GmfVersion asked) {
  const int version = choose_version(comm, path, asked, extent_of(mesh));
  Writer w(comm, path, version);
  agree(comm, [&] {
    version >= 4 ? write_sections<std::int64_t>(w, mesh) : write_sections<std::int32_t>(w, mesh);
    w.end();
  });
  w.commit();
}

void write_gmf_fields(const Comm& comm, const std::string& path, const FieldSlice& fields, GmfVersion asked) {
  const int version = choose_version(comm, path, asked, extent_of(fields));
  std::vector<std::int32_t> kinds{static_cast<std::int32_t>(fields.kinds.size())};
  for (const FieldKind k : fields.kinds) kinds.push_back(static_cast<std::int32_t>(k));
  const auto width = static_cast<std::size_t>(fields.width);
  Writer w(comm, path, version);
  agree(comm, [&] {
    w.section(Keyword::kSolAtVertices, kinds, fields.total, fields.first, fields.values.size() / width, width * 8,
              [&](std::size_t i, std::byte* p) { std::memcpy(p, fields.values.data() + i * width, width * 8); });
    w.end();
  });
  w.commit();
}

}  // namespace skein::io
