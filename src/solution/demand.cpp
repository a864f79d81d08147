// What a metric asks for, and the memory of the machine.
#include "solution/demand.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "metric/complexity.hpp"

namespace skein {

double predicted_tets(const Comm& comm, const DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  double sum = 0;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    AtVerts l;
    for (std::size_t k = 0; k < 4; ++k) l[k] = log_sqrt_det(m.log_metric[m.tet2vert[t][k]]);
    sum += mean_of_log_linear(l) * volume6(m, t) / 6;
  }
  return kResultTetsPerComplexity * comm.sum(sum);
}

double require_affordable(const Comm& comm, const DistMesh& dist, const std::string& name, double most) {
  const double tets = predicted_tets(comm, dist);
  const auto free = static_cast<double>(free_memory(comm));
  const double needed = kBytesPerTet * tets / comm.size();
  agree(comm, [&] {
    constexpr double kGiga = 1e9;
    if (most > 0 && !(tets <= most))
      throw Error(ExitCode::kInput,
                  fmt::format("{}: about {:.3g} tetrahedra are asked for, more than the limit of {:.3g}; use coarser "
                              "sizes, a smaller --complexity, or a greater --max-elements",
                              name, tets, most));
    if (most == 0 && !(needed <= free))
      throw Error(
          ExitCode::kInput,
          fmt::format("{}: about {:.3g} tetrahedra are asked for; they need {:.3g} GB in each process, and {:.3g} "
                      "GB are free for each; use coarser sizes (are their units right?), --complexity, or more "
                      "machines; --max-elements N sets another limit",
                      name, tets, needed / kGiga, free / kGiga));
  });
  return tets;
}

}  // namespace skein
