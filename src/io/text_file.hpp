// TextFile: a file of words and numbers, read by all ranks in byte ranges cut at line ends.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "comm/comm.hpp"

namespace skein::io {

/// A keyword of the file and the numbers that follow it. Numbers are counted from 0 through the whole file.
struct TextWord {
  static constexpr std::size_t kMaxName = 39;  ///< longer words are cut
  char text[kMaxName + 1] = {};
  std::int64_t line = 0;            ///< from 1
  std::int64_t begin = 0, end = 0;  ///< the numbers between this word and the next
  [[nodiscard]] std::string_view name() const noexcept { return text; }
  [[nodiscard]] std::int64_t size() const noexcept { return end - begin; }
};

/// Each rank holds the lines that begin in its even share of the bytes. What does not begin with a letter is a number,
/// as are nan and inf; # begins a comment up to the end of the line; any white space separates.
class TextFile {
 public:
  /// Collective. Throws Error(kInput) when the file is missing or is not text.
  TextFile(const Comm& comm, const std::string& path);

  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  /// All words of the file in order, the same on every rank.
  [[nodiscard]] const std::vector<TextWord>& words() const noexcept { return words_; }
  [[nodiscard]] std::int64_t lines() const noexcept { return lines_; }  ///< lines in the file

  /// Collective. Numbers [begin, begin + n) on every rank; n must be small. A token that is no whole number is
  /// kNoNumber.
  [[nodiscard]] std::vector<std::int64_t> whole_numbers(std::int64_t begin, std::int64_t n) const;
  static constexpr std::int64_t kNoNumber = INT64_MIN;

  /// Collective. Numbers [begin, begin + records * width), each rank its even slice of the records. `check(i, value,
  /// where)` sees each number once, i from 0, on the rank that parses it, and throws if it is wrong; where() is the
  /// head of the message ("path, line n").
  template <class T, class Check>
  [[nodiscard]] std::vector<T> slices(std::int64_t begin, std::int64_t records, int width, Check&& check) const;

 private:
  struct Piece {                     // the numbers between two words, as far as they are on this rank
    std::size_t begin = 0, end = 0;  // bytes of text_
    std::int64_t first = 0, size = 0;
    std::int64_t line = 0;
  };
  enum class Wanted : std::uint8_t { kNumber, kWholeNumber };
  void load(const Comm& comm);
  void scan(std::vector<TextWord>& mine, std::int64_t& numbers, std::int64_t& lines);
  void number_globally(std::int64_t numbers, std::int64_t lines, std::vector<TextWord>& mine);
  [[nodiscard]] std::string where(const Piece& piece, const char* p) const;
  [[noreturn]] void throw_bad_token(const Piece& piece, const char* p, Wanted wanted) const;
  /// Calls f(i, p, end, piece) for the numbers in [begin, end) that are on this rank; f moves p behind the number.
  template <class F>
  void for_numbers(std::int64_t begin, std::int64_t end, F&& f) const;
  template <class T>
  [[nodiscard]] std::vector<T> distribute(std::int64_t first, std::vector<T> mine, std::int64_t records,
                                          int width) const;

  const Comm& comm_;
  std::string path_;
  std::vector<char> text_;
  std::vector<Piece> pieces_;
  std::vector<TextWord> words_;
  std::int64_t first_number_ = 0;  // of this rank
  std::int64_t lines_ = 0;
};

/// The number that begins at p, as far as the next white space, comment or `end`; p moves behind it. Returns false
/// (and leaves p) when there is none. Reals may have the exponent letters e, E, d or D.
bool parse_number(const char*& p, const char* end, double& value) noexcept;
bool parse_number(const char*& p, const char* end, std::int64_t& value) noexcept;

}  // namespace skein::io

#include "io/text_file_inl.hpp"
