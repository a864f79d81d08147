// Merging of the input's vertices, and the line that tells of it.
#include "app/merge_input.hpp"

#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "base/text.hpp"
#include "dist/merge_vertices.hpp"

namespace skein::app {

void add_merge_option(CLI::App& verb, std::optional<double>& tolerance) {
  verb.add_option("--merge", tolerance,
                  "merge vertices of IN that are nearer than this times the diagonal of its bounding box")
      ->check(CLI::Range(0.0, 0.1));
}

void merge_input(const Comm& comm, std::optional<double> tolerance, MeshSlice& mesh, FieldSlice* values,
                 const std::function<void(const std::string&)>& note) {
  if (!tolerance) return;
  const MergeReport r = merge_vertices(comm, *tolerance, mesh, values);
  if (r.verts > 0) mesh.path += " after --merge";
  note(fmt::format("note: {} vertices merged; {} tetrahedra, {} triangles and {} edges dropped", grouped(r.verts),
                   grouped(r.tets), grouped(r.triangles), grouped(r.edges)));
}

}  // namespace skein::app
