// What memory a rank may still take.
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

#include "comm/impl.hpp"

namespace skein {
namespace {

constexpr std::int64_t kNoBound = std::numeric_limits<std::int64_t>::max();

/// The first number of a file; kNoBound if it has none ("max").
std::int64_t number_in(const char* path) {
  std::ifstream in(path);
  std::int64_t n = 0;
  return in >> n ? n : kNoBound;
}

/// Bytes of files in the control group's memory, which it gives back when they are needed.
std::int64_t files_kept() {
  std::ifstream in("/sys/fs/cgroup/memory.stat");
  std::string key;
  for (std::int64_t bytes = 0; in >> key >> bytes;) {
    if (key == "inactive_file") return bytes;
  }
  return 0;
}

/// Bytes that the machine, and the control group of this process, still have.
std::int64_t free_here() {
  std::int64_t free = kNoBound;
  std::ifstream in("/proc/meminfo");
  std::string key;
  for (std::int64_t kb = 0; in >> key;) {
    if (key == "MemAvailable:" && in >> kb) free = kb * 1024;
    in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  const std::int64_t most = number_in("/sys/fs/cgroup/memory.max");
  const std::int64_t used = number_in("/sys/fs/cgroup/memory.current");
  if (most != kNoBound && used != kNoBound)
    free = std::min(free, std::max<std::int64_t>(0, most - used + files_kept()));
  return free;
}

}  // namespace

std::int64_t free_memory(const Comm& comm) {
  MPI_Comm node = MPI_COMM_NULL;
  MPI_Comm_split_type(comm.impl().mpi, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  int ranks = 1;
  MPI_Comm_size(node, &ranks);
  MPI_Comm_free(&node);
  return comm.min(free_here() / ranks);
}

}  // namespace skein
