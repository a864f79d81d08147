// Methods as TOML: what `skein adapt --dump-config` prints and `--config` reads.
#pragma once
#include <string>
#include <string_view>

#include "comm/comm.hpp"
#include "kernel/method.hpp"

namespace skein {

/// The preset of this name. Throws Error(kUsage) with the names there are.
const Preset& find_preset(std::string_view name);

/// Every number of the method with its meaning, as a configuration file that parse_method() reads back to the same
/// method. `preset`: the name written as what it starts from.
std::string method_to_toml(const Method& method, std::string_view preset);

/// A method from a configuration file: the preset that its key `preset` names (else the default), with the numbers that
/// it gives in place of that one's. Throws Error(kInput) naming `path`, line and key for what is no TOML, for unknown
/// sections and keys (with the nearest that there is), and for values of the wrong type or out of bounds.
Method parse_method(std::string_view text, const std::string& path);

/// Collective. Read by rank 0; the same method on every rank. Throws Error(kInput) on all ranks.
Method read_method(const Comm& comm, const std::string& path);

}  // namespace skein
