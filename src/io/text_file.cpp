// Loading, cutting and counting of text files; parsing of numbers.
#include "io/text_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <cstring>

namespace skein::io {
namespace {

constexpr std::int64_t kStep = 1 << 16;  // bytes read at a time when looking for the end of the last line
constexpr std::size_t kMaxWords = 1000;  // per rank; a file of numbers has a few dozen

bool is_letter(char c) noexcept { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '"'; }

bool is_nan_or_inf(const char* p, std::size_t n) noexcept {
  const auto lower = [&](std::size_t i) { return static_cast<char>(p[i] | 0x20); };
  if (n < 3) return false;
  return (lower(0) == 'n' && lower(1) == 'a' && lower(2) == 'n') ||
         (lower(0) == 'i' && lower(1) == 'n' && lower(2) == 'f');
}

/// from_chars takes no plus sign. A sign after the plus stays in front of it, and so is no number.
const char* skip_plus(const char* p, const char* end) noexcept {
  const bool plus = end - p >= 2 && p[0] == '+' && p[1] != '+' && p[1] != '-';
  return plus ? p + 1 : p;
}

void read_text(const InputFile& in, std::int64_t at, char* out, std::int64_t n) {
  in.read(at, std::as_writable_bytes(std::span<char>(out, static_cast<std::size_t>(n))));
}

/// The bytes of the lines that begin in [first, last).
std::vector<char> read_lines(const InputFile& in, std::int64_t first, std::int64_t last) {
  const std::int64_t from = std::max<std::int64_t>(0, first - 1);  // one more, to see whether a line ends before
  std::vector<char> text(static_cast<std::size_t>(last - from));
  read_text(in, from, text.data(), last - from);
  if (first > 0) {
    const auto line_end = std::ranges::find(text, '\n');
    if (line_end == text.end()) return {};
    text.erase(text.begin(), line_end + 1);
    if (text.empty()) return {};
  }
  while (last < in.size() && !text.empty() && text.back() != '\n') {
    const std::size_t old = text.size();
    const std::int64_t n = std::min(kStep, in.size() - last);
    text.resize(old + static_cast<std::size_t>(n));
    read_text(in, last, text.data() + old, n);
    last += n;
    const auto line_end = std::find(text.begin() + static_cast<std::ptrdiff_t>(old), text.end(), '\n');
    if (line_end != text.end()) text.erase(line_end + 1, text.end());
  }
  return text;
}

}  // namespace

bool parse_number(const char*& p, const char* end, std::int64_t& value) noexcept {
  const char* const start = skip_plus(p, end);
  const auto [stop, error] = std::from_chars(start, end, value);
  if (error != std::errc{} || (stop != end && !ends_token(*stop))) return false;
  p = stop;
  return true;
}

bool parse_number(const char*& p, const char* end, double& value) noexcept {
  const char* const start = skip_plus(p, end);
  const auto [stop, error] = std::from_chars(start, end, value);
  if (error == std::errc{} && (stop == end || ends_token(*stop))) {
    p = stop;
    return true;
  }
  // Fortran exponents, and numbers too small or too large for a double
  char copy[128];
  const char* const last = token_end(start, end);
  const auto n = static_cast<std::size_t>(last - start);
  if (n == 0 || n >= sizeof copy) return false;
  for (std::size_t i = 0; i < n; ++i) copy[i] = start[i] == 'd' || start[i] == 'D' ? 'e' : start[i];
  copy[n] = 0;
  const auto again = std::from_chars(copy, copy + n, value);
  if (again.ptr != copy + n || again.ec == std::errc::invalid_argument) return false;
  if (again.ec == std::errc::result_out_of_range) value = std::strtod(copy, nullptr);
  p = last;
  return true;
}

TextFile::TextFile(const Comm& comm, const std::string& path) : comm_(comm), path_(path) {
  load(comm);
  std::vector<TextWord> mine;
  std::int64_t numbers = 0, lines = 0;
  agree(comm, [&] { scan(mine, numbers, lines); });
  number_globally(numbers, lines, mine);
}

void TextFile::load(const Comm& comm) {
  const InputFile in(comm, path_);
  agree(comm, [&] {
    if (in.size() == 0) throw Error(ExitCode::kInput, fmt::format("{}: the file is empty", path_));
    const Slice range = even_slice(in.size(), comm.rank(), comm.size());
    if (range.size() > 0) text_ = read_lines(in, range.first, range.last);
    if (std::ranges::find(text_, '\0') != text_.end()) {
      throw Error(ExitCode::kInput,
                  fmt::format("{}: not a text file; binary files must end in .meshb or .solb", path_));
    }
  });
}

void TextFile::scan(std::vector<TextWord>& mine, std::int64_t& numbers, std::int64_t& lines) {
  const char* p = text_.data();
  const char* const end = p + text_.size();
  const char* line_mark = p;  // lines are counted up to here
  pieces_.push_back({});
  const auto close = [&](const char* at) {
    pieces_.back().end = static_cast<std::size_t>(at - text_.data());
    pieces_.back().size = numbers - pieces_.back().first;
    lines += std::count(line_mark, at, '\n');
    line_mark = at;
  };
  for (p = next_token(p, end); p < end; p = next_token(p, end)) {
    const char* const stop = token_end(p, end);
    const auto n = static_cast<std::size_t>(stop - p);
    if (is_letter(*p) && !is_nan_or_inf(p, n)) {
      close(p);
      if (mine.size() >= kMaxWords) {
        throw Error(ExitCode::kInput,
                    fmt::format("{}: not a Medit text file: too many words that are no numbers", path_));
      }
      TextWord w;
      std::memcpy(w.text, p, std::min(n, TextWord::kMaxName));
      w.line = lines;
      w.begin = numbers;
      mine.push_back(w);
      pieces_.push_back({static_cast<std::size_t>(stop - text_.data()), 0, numbers, 0, lines});
    } else {
      ++numbers;
    }
    p = stop;
  }
  close(end);
}

void TextFile::number_globally(std::int64_t numbers, std::int64_t lines, std::vector<TextWord>& mine) {
  first_number_ = comm_.exclusive_sum(numbers);
  const std::int64_t first_line = comm_.exclusive_sum(lines) + 1;
  for (Piece& p : pieces_) p.line += first_line;
  for (TextWord& w : mine) {
    w.line += first_line;
    w.begin += first_number_;
  }
  words_ = comm_.all_gather(mine);
  const std::int64_t all = comm_.sum(numbers);
  for (std::size_t i = 0; i < words_.size(); ++i) words_[i].end = i + 1 < words_.size() ? words_[i + 1].begin : all;
  lines_ = comm_.sum(lines);
}

std::string TextFile::where(const Piece& piece, const char* p) const {
  return fmt::format("{}, line {}", path_, piece.line + std::count(text_.data() + piece.begin, p, '\n'));
}

void TextFile::throw_bad_token(const Piece& piece, const char* p, Wanted wanted) const {
  const char* stop = token_end(p, text_.data() + piece.end);
  const std::string_view token(p, std::min<std::size_t>(40, static_cast<std::size_t>(stop - p)));
  throw Error(ExitCode::kInput, fmt::format("{}: '{}' is not a {}: correct the file", where(piece, p), token,
                                            wanted == Wanted::kWholeNumber ? "whole number" : "number"));
}

std::vector<std::int64_t> TextFile::whole_numbers(std::int64_t begin, std::int64_t n) const {
  std::vector<std::int64_t> mine;
  for_numbers(begin, begin + n, [&](std::int64_t, const char*& p, const char* stop, const Piece&) {
    std::int64_t v = 0;
    if (!parse_number(p, stop, v)) {
      v = kNoNumber;
      p = token_end(p, stop);
    }
    mine.push_back(v);
  });
  return comm_.all_gather(mine);
}

}  // namespace skein::io
