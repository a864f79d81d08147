// Cuts a mesh into several numbers of parts and prints one JSON line for each; can write the dual graph for others.
#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "io/mesh_io.hpp"
#include "partition/distribute.hpp"
#include "partition/graph.hpp"
#include "partition/partition.hpp"

namespace {

using namespace skein;

/// The text format of Metis: "nodes edges", then for each node its neighbours, from 1. One rank only.
void write_graph(const Comm& comm, const DistMesh& dist, const std::string& path) {
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  const DistGraph d = dual_graph(comm, dist, work);
  std::FILE* out = std::fopen(path.c_str(), "w");
  if (out == nullptr) throw Error(ExitCode::kOutput, path + ": cannot be written");
  fmt::print(out, "{} {}\n", d.graph.nodes(), d.graph.edge.size() / 2);
  for (const NodeId v : IdRange<NodeId>(d.graph.nodes())) {
    for (const Edge& e : d.graph.edges(v)) fmt::print(out, "{} ", num(e.to) + 1);
    fmt::print(out, "\n");
  }
  std::fclose(out);
}

int run(const Comm& comm, const std::vector<std::string>& args) {
  if (args.size() < 3) {
    if (comm.is_root()) fmt::print(stderr, "usage: partition_bench MESH hilbert|multilevel|graph PARTS...|FILE\n");
    return 1;
  }
  const DistMesh dist = distribute(comm, read_mesh(comm, args[0]));
  if (args[1] == "graph") {
    write_graph(comm, dist, args[2]);
    return 0;
  }
  const auto method = args[1] == "hilbert" ? PartitionMethod::kHilbert : PartitionMethod::kMultilevel;
  const std::vector<double> work(dist.mesh.tet_slots(), 1.0);
  for (std::size_t i = 2; i < args.size(); ++i) {
    const int parts = std::atoi(args[i].c_str());
    const double cpu = cpu_time(), wall = wall_time();
    const auto part = partition(comm, dist, work, parts, method);
    const double cpu_used = comm.sum(cpu_time() - cpu), wall_used = comm.max(wall_time() - wall);
    const PartitionStats s = partition_stats(comm, dist, part, work, parts);
    const auto memory = comm.max(peak_memory());
    if (!comm.is_root()) continue;
    fmt::print(R"({{"parts": {}, "tets": {}, "ranks": {}, "cut": {}, "imbalance": {:.4f}, "components": {}, )", parts,
               dist.global_tets, comm.size(), s.cut_faces, s.imbalance, s.components);
    fmt::print("\"cpu\": {:.3f}, \"wall\": {:.3f}, \"memory\": {}}}\n", cpu_used, wall_used, memory);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Environment env(argc, argv);
  const Comm comm = Comm::world();
  try {
    return run(comm, {argv + 1, argv + argc});
  } catch (const AgreedError& e) {
    if (comm.is_root()) fmt::print(stderr, "partition_bench: {}\n", e.what());
    return static_cast<int>(e.code());
  } catch (const Error& e) {
    fmt::print(stderr, "partition_bench: {}\n", e.what());
    abort_all(e.code());
  }
}
