// agree(): one rank's error becomes the same exception on all ranks.
#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "comm/impl.hpp"
#include "comm/verdict.hpp"

namespace skein {

Verdict verdict_of(const Comm& comm, const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const Error& e) {
    const bool agreed = dynamic_cast<const AgreedError*>(&e) != nullptr;
    return {e.code() == ExitCode::kOk ? ExitCode::kInternal : e.code(), e.what(), agreed};
  } catch (const std::bad_alloc&) {
    return {ExitCode::kInternal, fmt::format("out of memory on rank {} of {}; use more ranks or a coarser mesh",
                                             num(comm.rank()), comm.size())};
  } catch (const std::exception& e) {
    return {ExitCode::kInternal, fmt::format("internal error on rank {}: {}", num(comm.rank()), e.what())};
  } catch (...) {
    return {ExitCode::kInternal, fmt::format("internal error on rank {}: unknown exception", num(comm.rank()))};
  }
}

void agree_on(const Comm& comm, const Verdict& mine) {
  const bool ok = mine.code == ExitCode::kOk;
  const std::int32_t failed = comm.min(ok ? std::int32_t{comm.size()} : num(comm.rank()));
  if (failed == comm.size()) return;
  std::string line = mine.line;
  std::replace(line.begin(), line.end(), '\n', ' ');
  struct Head {
    std::int64_t code, length;
  } head{static_cast<std::int64_t>(mine.code), static_cast<std::int64_t>(line.size())};
  detail::broadcast_bytes(comm, &head, sizeof head, Rank{failed});
  line.resize(static_cast<std::size_t>(head.length));
  detail::broadcast_bytes(comm, line.data(), line.size(), Rank{failed});
  throw AgreedError(static_cast<ExitCode>(head.code), line);
}

void agree(const Comm& comm, const std::function<void()>& work) { agree_on(comm, verdict_of(comm, work)); }

}  // namespace skein
