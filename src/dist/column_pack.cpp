// Packing and unpacking of vertex columns.
#include "dist/column_pack.hpp"

#include <cstring>

#include "base/error.hpp"
#include "mesh/free_slots.hpp"

namespace skein {

ColumnLayout layout_of(const Comm& comm, const TetMesh& m) {
  std::array<std::int64_t, kVertColumnCount> here{};
  std::size_t i = 0;
  for_each_vert_column(m, [&](const auto& c) { here[i++] = c.empty() ? 0 : static_cast<std::int64_t>(width_of(c)); });
  ColumnLayout out;
  out.width = here;
  comm.reduce(std::span<std::int64_t>(out.width), Op::kMax);
  agree(comm, [&] {
    if (m.vert_slots() > 0 && here != out.width)
      throw Error(ExitCode::kInternal, "migrate: the ranks keep different columns at their vertices");
  });
  i = 0;
  for_each_vert_column(m, [&](const auto& c) {
    out.at[i] = out.bytes;
    out.bytes += static_cast<std::size_t>(out.width[i++]) * sizeof(EntryOf<decltype(c)>);
  });
  return out;
}

std::vector<std::byte> pack_columns(const TetMesh& m, const ColumnLayout& layout, const std::vector<VertId>& verts) {
  std::vector<std::byte> out(verts.size() * layout.bytes);
  std::size_t i = 0;
  for_each_vert_column(m, [&](const auto& c) {
    std::byte* to = out.data() + layout.at[i++];
    if (c.empty()) return;
    const std::size_t n = width_of(c) * sizeof(EntryOf<decltype(c)>);
    for (const VertId v : verts) {
      std::memcpy(to, c.raw().data() + idx(v) * width_of(c), n);
      to += layout.bytes;
    }
  });
  return out;
}

namespace {
void set_width(VertFields& c, std::int64_t width) noexcept { c.width = static_cast<int>(width); }
template <class T>
void set_width(IdVector<VertId, T>&, std::int64_t) noexcept {}

/// A copy of a vertex comes to one that is here: flags are joined, and of all else copies have the same.
template <class T>
void join_copy(T& here, const T& in) noexcept {
  if constexpr (FlagSet<T>) {
    here |= in;
  } else {
    here = in;
  }
}
}  // namespace

void unpack_columns(TetMesh& m, const ColumnLayout& layout, const std::vector<std::byte>& in,
                    const std::vector<VertId>& verts, const std::vector<VertId>& fresh, std::size_t slots) {
  std::size_t i = 0;
  for_each_vert_column(m, [&](auto& c) {
    const std::byte* from = in.data() + layout.at[i];
    set_width(c, layout.width[i]);
    if (layout.width[i++] == 0) return;
    reserve_with_slack(c.raw(), slots * width_of(c));
    resize_column(c, slots);
    for (const VertId v : fresh) clear_entry(c, v);
    EntryOf<decltype(c)> copy;
    for (const VertId v : verts) {
      for (std::size_t k = 0; k < width_of(c); ++k) {
        std::memcpy(&copy, from + k * sizeof copy, sizeof copy);
        join_copy(c.raw()[idx(v) * width_of(c) + k], copy);
      }
      from += layout.bytes;
    }
  });
}

}  // namespace skein
