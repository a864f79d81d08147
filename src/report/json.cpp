// PhaseCost as JSON, and the writing of JSON files.
#include "report/json.hpp"

#include <fmt/core.h>

#include "comm/file.hpp"

namespace skein {

Json to_json(const PhaseCost& p) {
  Json operations = Json::object();
  for (const auto& [name, n] : p.operations) operations[name] = n;
  return Json{{"name", p.name},
              {"seconds", {{"min", p.seconds_min}, {"mean", p.seconds_mean}, {"max", p.seconds_max}}},
              {"busy", {{"min", p.busy_min}, {"mean", p.busy_mean}, {"max", p.busy_max}}},
              {"cpu", {{"min", p.cpu_min}, {"mean", p.cpu_mean}, {"max", p.cpu_max}}},
              {"communication_cpu", {{"min", p.comm_cpu_min}, {"mean", p.comm_cpu_mean}, {"max", p.comm_cpu_max}}},
              {"balance", p.balance},
              {"elements", p.elements},
              {"elements_max", p.elements_max},
              {"operations", operations},
              {"bytes_sent", p.bytes_sent},
              {"bytes_sent_max", p.bytes_sent_max},
              {"messages_sent", p.messages_sent},
              {"messages_sent_max", p.messages_sent_max},
              {"collectives", p.collectives}};
}

void write_json(const Comm& comm, const std::string& path, const Json& json) {
  OutputFile file(comm, path);
  agree(comm, [&] {
    if (!comm.is_root()) return;
    const std::string text = json.dump(2) + "\n";
    file.write(0, std::as_bytes(std::span<const char>(text.data(), text.size())));
  });
  file.commit();
}

}  // namespace skein
