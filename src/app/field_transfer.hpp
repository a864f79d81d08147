// The fields that travel with the mesh: --field-in and --field-out.
#pragma once
#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/run_report.hpp"
#include "comm/comm.hpp"
#include "dist/dist_mesh.hpp"
#include "mesh/mesh_slice.hpp"
#include "solution/transfer.hpp"

namespace skein::app {

struct FieldOptions {
  std::vector<std::string> in;  ///< solutions at the vertices of the input
  std::string out;
};
void add_field_options(CLI::App& verb, FieldOptions& o);

/// Collective. Throws Error(kUsage) when one of the options needs the other (`output`, the mesh, may hold fields
/// itself), and Error(kInput) or Error(kOutput) when a file is missing or cannot be written.
void require_fields(const Comm& comm, const FieldOptions& o, const std::string& output);

/// Fields on their way from the input to the new mesh. Without --field-in nothing happens.
class TravellingFields {
 public:
  explicit TravellingFields(const FieldOptions& options) : options_(options) {}

  /// Collective. Reads the files; gives their numbers behind those of `metric`, vertex by vertex. Throws Error(kInput)
  /// when the file has not one value per vertex of `mesh`.
  [[nodiscard]] FieldSlice read_behind(const Comm& comm, const MeshSlice& mesh, FieldSlice metric);
  /// Takes the numbers behind the first `keep` of each vertex out of the column `fields`. Not collective.
  void take_from(DistMesh& dist, int keep);
  /// Collective. Keeps the mesh as it is now, cut for the work that adapting will be: so most points of the new mesh
  /// will be found by the rank that has them.
  void keep_mesh(const Comm& comm, DistMesh& dist);
  /// Collective. Puts the fields at the vertices of the new mesh into its column `fields`, and forgets the old mesh.
  void arrive(DistMesh& dist, int threads, PhaseLog& log);

  [[nodiscard]] bool any() const noexcept { return !out_.kinds.empty(); }
  [[nodiscard]] const FieldsOut& out() const noexcept { return out_; }

 private:
  FieldOptions options_;
  FieldsOut out_;
  VertFields values_;
  std::optional<Background> old_;
};

}  // namespace skein::app
