// Cuts a mesh into several numbers of parts and prints one JSON line for each; can write the dual graph for others.
#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "comm/comm.hpp"
#include "dist/distribute.hpp"
#include "dist/dual_graph.hpp"
#include "dist/migrate.hpp"
#include "dist/partition.hpp"
#include "dist/rebalance.hpp"
#include "io/mesh_io.hpp"
#include "partition/graph.hpp"
#include "partition/hilbert.hpp"

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

/// Balances the ranks' parts when tetrahedra near the middle of the mesh have become `factor` times as much work.
void balance_ranks(const Comm& comm, DistMesh& dist, double factor) {
  const std::vector<double> equal(dist.mesh.tet_slots(), 1.0);
  migrate(comm, dist, partition(comm, dist, equal, comm.size(), PartitionMethod::kMultilevel));
  const TetMesh& m = dist.mesh;
  const Box box = global_box(comm, std::span<const Vec3>(m.coords.raw()));
  const Vec3 middle = 0.5 * (box.low + box.high);
  std::vector<double> work(m.tet_slots(), 1.0);
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    const Vec3 x = m.coords[m.tet2vert[t][0]];
    if (x.x < middle.x && x.y < middle.y) work[idx(t)] = factor;
  }
  const IdVector<TetId, PartId> stay(m.tet_slots(), part_of(comm.rank()));
  const PartitionStats before = partition_stats(comm, dist, stay, work, comm.size());
  const double cpu = cpu_time();
  const auto dest = rebalance(comm, dist, work);
  const double cpu_used = comm.sum(cpu_time() - cpu);
  IdVector<TetId, PartId> part(dest.size());
  for (const TetId t : IdRange<TetId>(dest.size())) part[t] = part_of(dest[t]);
  const PartitionStats after = partition_stats(comm, dist, part, work, comm.size());
  double mine = 0, moved = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    mine += work[idx(t)];
    moved += dest[t] != comm.rank() ? work[idx(t)] : 0;
  }
  const double total = comm.sum(mine);
  const double surplus = comm.sum(std::max(0.0, mine - total / comm.size()));
  moved = comm.sum(moved);
  if (!comm.is_root()) return;
  fmt::print(R"({{"ranks": {}, "tets": {}, "imbalance": [{:.4f}, {:.4f}], "cut": [{}, {}], "components": [{}, {}], )",
             comm.size(), dist.global_tets, before.imbalance, after.imbalance, before.cut_faces, after.cut_faces,
             before.components, after.components);
  fmt::print("\"moved\": {:.4f}, \"surplus\": {:.4f}, \"cpu\": {:.3f}}}\n", moved / total, surplus / total, cpu_used);
}

int run(const Comm& comm, const std::vector<std::string>& args) {
  if (args.size() < 3) {
    if (comm.is_root())
      fmt::print(stderr, "usage: partition_bench MESH hilbert|multilevel|graph|rebalance PARTS...|FILE|FACTOR\n");
    return 1;
  }
  DistMesh dist = distribute(comm, read_mesh(comm, args[0]));
  if (args[1] == "graph") {
    write_graph(comm, dist, args[2]);
    return 0;
  }
  if (args[1] == "rebalance") {
    balance_ranks(comm, dist, std::atof(args[2].c_str()));
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
