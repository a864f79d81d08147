// Templates of TextFile.
#pragma once
#include <algorithm>
#include <type_traits>

#include "comm/exchange.hpp"
#include "comm/file.hpp"
#include "io/text_file.hpp"

namespace skein::io {

constexpr bool is_blank(char c) noexcept { return static_cast<unsigned char>(c) <= ' '; }
constexpr bool ends_token(char c) noexcept { return is_blank(c) || c == '#'; }

/// The first character of the next token at or after p, comments passed over; `end` when there is none.
inline const char* next_token(const char* p, const char* end) noexcept {
  for (;;) {
    while (p < end && is_blank(*p)) ++p;
    if (p == end || *p != '#') return p;
    while (p < end && *p != '\n') ++p;
  }
}
inline const char* token_end(const char* p, const char* end) noexcept {
  while (p < end && !ends_token(*p)) ++p;
  return p;
}

template <class F>
void TextFile::for_numbers(std::int64_t begin, std::int64_t end, F&& f) const {
  for (const Piece& piece : pieces_) {
    const std::int64_t first = first_number_ + piece.first;
    if (first >= end || first + piece.size <= begin) continue;
    const char* p = text_.data() + piece.begin;
    const char* const stop = text_.data() + piece.end;
    for (std::int64_t i = first; i < std::min(end, first + piece.size); ++i) {
      p = next_token(p, stop);
      if (i < begin) {
        p = token_end(p, stop);
      } else {
        f(i, p, stop, piece);
      }
    }
  }
}

template <class T>
std::vector<T> TextFile::distribute(std::int64_t first, std::vector<T> mine, std::int64_t records, int width) const {
  Packets<T> send;
  const std::int64_t last = first + static_cast<std::int64_t>(mine.size());
  for (std::int64_t i = first; i < last;) {
    const Rank r = slice_owner(records, i / width, comm_.size());
    i = std::min(last, even_slice(records, r, comm_.size()).last * width);
    send.rank.push_back(r);
    send.offset.push_back(static_cast<std::size_t>(i - first));
  }
  send.items = std::move(mine);
  return exchange(comm_, send).items;  // blocks come by source rank, which is the order in the file
}

template <class T, class Check>
std::vector<T> TextFile::slices(std::int64_t begin, std::int64_t records, int width, Check&& check) const {
  std::vector<T> mine;
  std::int64_t first = 0;
  agree(comm_, [&] {
    const std::int64_t end = begin + records * width;
    for_numbers(begin, end, [&](std::int64_t i, const char*& p, const char* stop, const Piece& piece) {
      if (mine.empty()) {
        first = i - begin;
        mine.reserve(static_cast<std::size_t>(std::min(end - i, piece.size)));
      }
      const char* const start = p;
      T value;
      if (!parse_number(p, stop, value)) {
        throw_bad_token(piece, start, std::is_integral_v<T> ? Wanted::kWholeNumber : Wanted::kNumber);
      }
      check(i - begin, value, [&] { return where(piece, start); });
      mine.push_back(value);
    });
  });
  return distribute(first, std::move(mine), records, width);
}

}  // namespace skein::io
