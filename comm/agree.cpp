// agree(): one rank's error becomes the same exception on all ranks.
#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "comm/impl.hpp"

namespace skein {
namespace {

struct Verdict {
  ExitCode code = ExitCode::kOk;
  std::string line;
};

Verdict run(const Comm& comm, const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const Error& e) {
    return {e.code() == ExitCode::kOk ? ExitCode::kInternal : e.code(), e.what()};
  } catch (const std::bad_alloc&) {
    return {ExitCode::kInternal, fmt::format("out of memory on rank {} of {}; use more ranks or a coarser mesh",
                                             num(comm.rank()), comm.size())};
  } catch (const std::exception& e) {
    return {ExitCode::kInternal, fmt::format("internal error on rank {}: {}", num(comm.rank()), e.what())};
  } catch (...) {
    return {ExitCode::kInternal, fmt::format("internal error on rank {}: unknown exception", num(comm.rank()))};
  }
}

}  // namespace

void agree(const Comm& comm, const std::function<void()>& work) {
  Verdict mine = run(comm, work);
  const bool ok = mine.code == ExitCode::kOk;
  const std::int32_t failed = comm.min(ok ? std::int32_t{comm.size()} : num(comm.rank()));
  if (failed == comm.size()) return;
  std::replace(mine.line.begin(), mine.line.end(), '\n', ' ');
  struct Head {
    std::int64_t code, length;
  } head{static_cast<std::int64_t>(mine.code), static_cast<std::int64_t>(mine.line.size())};
  detail::broadcast_bytes(comm, &head, sizeof head, Rank{failed});
  mine.line.resize(static_cast<std::size_t>(head.length));
  detail::broadcast_bytes(comm, mine.line.data(), mine.line.size(), Rank{failed});
  throw AgreedError(static_cast<ExitCode>(head.code), mine.line);
}

}  // namespace skein
