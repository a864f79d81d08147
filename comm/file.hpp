// Files read and written by all ranks at once, each its own slices.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "comm/comm.hpp"

namespace skein {

/// The half-open range of n items that rank r of P has in an even division: [n*r/P, n*(r+1)/P).
struct Slice {
  std::int64_t first = 0, last = 0;
  [[nodiscard]] std::int64_t size() const noexcept { return last - first; }
};
Slice even_slice(std::int64_t n, Rank r, int ranks) noexcept;
/// The rank whose even_slice has item i. @pre 0 <= i < n.
Rank slice_owner(std::int64_t n, std::int64_t i, int ranks) noexcept;

/// A file open for reading on all ranks.
class InputFile {
 public:
  /// Collective. Throws Error(kInput) on all ranks when the file is missing or not readable.
  InputFile(const Comm& comm, const std::string& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  [[nodiscard]] std::int64_t size() const noexcept;  ///< bytes
  /// Not collective. Fills `out` from byte `at`; throws Error(kInput) ("truncated") when the file ends before. Larger
  /// than 2 GiB is fine.
  void read(std::int64_t at, std::span<std::byte> out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A file written by all ranks under a temporary name beside `path`; commit() gives it its name. Without commit the
/// temporary file is removed; an existing file is replaced by commit() only. `comm` must outlive the file.
class OutputFile {
 public:
  /// Collective. Throws Error(kOutput) on all ranks when the folder is missing or cannot be written.
  OutputFile(const Comm& comm, const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  /// Not collective. Throws Error(kOutput) when the device is full; commit() then fails, too. @pre slices of different
  /// ranks do not overlap.
  void write(std::int64_t at, std::span<const std::byte> data);
  /// Collective. Syncs, checks that all was written, and renames. Throws Error(kOutput) on all ranks otherwise.
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Removes the temporary files of this process, for a signal handler that ends it. May be called at any time.
void remove_temporary_files() noexcept;

}  // namespace skein
