// skein adapt with the library: reads slices, adapts arrays in memory, writes slices. To be compared with the program.
//
//     in_memory IN (--metric | --size) SOL OUT OUT-FIELDS
#include <cstdio>
#include <string>
#include <utility>

#include "api/slices.hpp"
#include "comm/comm.hpp"
#include "io/mesh_io.hpp"

namespace skein {
namespace {

void run(const Comm& comm, const std::string& in, const std::string& kind, const std::string& sol,
         const std::string& out, const std::string& out_fields) {
  SlicedMesh mesh = to_sliced_mesh(read_mesh(comm, in));
  FieldSlice values = read_fields(comm, sol);
  Fields fields;
  if (!out_fields.empty()) fields = {values.width, values.values};
  Target target =
      kind == "--metric" ? Target::metric(std::move(values.values)) : Target::size(std::move(values.values));
  Adapted<SlicedMesh> adapted = adapt(MPI_COMM_WORLD, std::move(mesh), std::move(target), std::move(fields));
  const std::int64_t bytes = comm.max(peak_memory());
  if (comm.is_root()) {
    std::printf("%lld tetrahedra, peak memory of a rank %.1f MB\n", static_cast<long long>(adapted.report.tets),
                double(bytes) / 1e6);
  }
  const auto n = static_cast<std::int64_t>(adapted.mesh.coords.size());
  if (!out_fields.empty()) {
    values.values = std::move(adapted.fields.values);
    values.first = comm.exclusive_sum(n), values.total = comm.sum(n);
    write_fields(comm, out_fields, values);
  }
  write_mesh(comm, out, to_mesh_slice(comm, std::move(adapted.mesh)));
}

}  // namespace
}  // namespace skein

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const skein::Environment environment(argc, argv);
  const skein::Comm comm = skein::Comm::world();
  skein::run(comm, argv[1], argv[2], argv[3], argv[4], argc > 5 ? argv[5] : "");
}
