// What a run that makes a mesh has in common: progress, the end of the flow, the report (docs/report.md).
#pragma once
#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "app/files.hpp"
#include "app/threads.hpp"
#include "comm/comm.hpp"
#include "comm/phase_log.hpp"
#include "dist/dist_mesh.hpp"
#include "io/mesh_io.hpp"
#include "mesh/mesh_slice.hpp"
#include "report/census.hpp"
#include "report/json.hpp"

namespace skein::app {

/// Options of the verbs that make a mesh.
struct RunOptions {
  std::string output, report, metric_out;
  int threads = kThreadsNotGiven;  ///< see settle_threads
  bool quiet = false;
  GmfVersion format = GmfVersion::kLowest;
  InputFiles inputs = InputFiles::kKept;
};
void add_run_options(CLI::App& verb, RunOptions& o);

/// Collective. Throws Error(kOutput) unless all outputs can be made, and Error(kUsage) as require_distinct() does.
/// `more`: an output that is not among the options.
void require_outputs(const Comm& comm, const RunOptions& o, const std::vector<std::string>& inputs,
                     const std::string& more = {});

/// The name under which a mesh is written that the end check has found wrong: out.mesh becomes out.suspect.mesh.
std::string suspect_path(const std::string& output);
/// Collective. Writes the mesh under suspect_path(output).
void write_suspect(const Comm& comm, const std::string& output, DistMesh dist);

/// Collective. The head of the log: version, host, date, ranks and threads, the command line.
void note_head(const Comm& comm, int threads, PhaseLog& log);
/// How many rounds there were, and why no more.
void note_rounds(const Comm& comm, PhaseLog& log, int most);

/// How progress is to be shown on standard output: lines that overwrite themselves on a terminal (but not under mpirun,
/// which collects the output of the ranks), plain lines elsewhere.
PhaseLog::Output progress_output(const RunOptions& options);

/// Fields on the new mesh: its column `fields`.
struct FieldsOut {
  std::string path;  ///< .sol or .solb; empty: with the mesh only (.vtu, .pvtu)
  std::vector<FieldKind> kinds;
  std::vector<std::string> names;
};

/// The run as a whole: wall times and sizes, from which the report is made.
class RunRecord {
 public:
  RunRecord(const Comm& comm, const RunOptions& options);

  PhaseLog log;
  std::string input;
  Json options = Json::object();  ///< as given on the command line
  std::int64_t elements_in = 0, vertices_in = 0;
  Json surface;               ///< null: it was to stay as it is
  Json end_check;             ///< null: there was no mesh to compare with
  Census before;              ///< of the input; empty: there was no mesh
  double predicted_tets = 0;  ///< of the metric, before the work; 0: not known

  /// Seconds since the last lap (or the beginning) belong to `name`. Not collective.
  void lap(const std::string& name);
  /// Collective. The rest of the flow: statistics, writing of mesh, metric, fields and report. The log-metric is the
  /// column log_metric.
  void finish(const Comm& comm, DistMesh dist, const FieldsOut& fields = {});

 private:
  [[nodiscard]] Json to_json(const Comm& comm, const DistMesh& dist, const Json& statistics) const;
  void note_result(const MeshStatistics& s, const Census& after, const std::vector<WorstTet>& worst);
  RunOptions run_;
  double begin_, lap_;
  std::vector<std::pair<std::string, double>> laps_;
};

}  // namespace skein::app
