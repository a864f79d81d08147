// What the tests of io share: a sample mesh, cutting and joining of slices, a folder for files, error lines.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "mesh/mesh_slice.hpp"

namespace skein::test {

/// A box of n*n*n cubes, six tetrahedra each, as one slice that has everything (totals set, first 0). Coordinates need
/// all their bits; references may be negative; ridges, corners and required entities are there.
MeshSlice whole_box(int n);
/// Fields (scalar, tensor, vector) at the vertices, as one slice.
FieldSlice whole_fields(std::int64_t verts);
double volume(const MeshSlice& whole);

/// The slice of a rank: even, or uneven with empty ones.
MeshSlice cut(const MeshSlice& whole, const Comm& comm, bool even = true);
FieldSlice cut(const FieldSlice& whole, const Comm& comm, bool even = true);
/// Collective. The slices of all ranks, one behind the other. Checks `first` and, when `even`, the sizes.
MeshSlice join(const Comm& comm, const MeshSlice& mine, bool even = true);
FieldSlice join(const Comm& comm, const FieldSlice& mine, bool even = true);
/// Bit for bit; reports differences as test failures.
void expect_same(const MeshSlice& a, const MeshSlice& b);
void expect_same(const FieldSlice& a, const FieldSlice& b);

/// A folder that all ranks know; removed at the end.
class Folder {
 public:
  explicit Folder(const Comm& comm);  ///< Collective.
  ~Folder();                          ///< Collective.
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  /// Collective. Rank 0 writes the file; all may read it then.
  std::string write(const std::string& name, const std::vector<std::byte>& bytes) const;
  std::string write(const std::string& name, const std::string& text) const;
  /// Collective. Names of what is in it when all ranks have come here.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  const Comm& comm_;
  std::string path_;
};
std::vector<std::byte> bytes_of_file(const std::string& path);

/// Collective. The line of the Error that f must throw on all ranks alike; "" (and a failure) when it does not.
std::string error_line(const Comm& comm, const std::function<void()>& f);
/// Collective. As error_line, but f may succeed, too ("").
std::string error_or_success(const Comm& comm, const std::function<void()>& f);
void expect_contains(const std::string& line, const std::vector<std::string>& parts);

}  // namespace skein::test
