// Skein as the guest of a program that has MPI and a communicator of its own.
#pragma once
#include <functional>

#include "comm/comm.hpp"
#include "comm/mpi_handle.hpp"

namespace skein {

/// Seconds that a rank with an error of its own waits for the others to have one, too (run_as_guest).
inline constexpr double kPatience = 3;

/// Collective over the caller's communicator. Runs `work` on a duplicate of it, which lives as long as the call, so
/// that nothing of the caller's meets anything of Skein's; neither MPI nor the communicator is changed.
///
/// Whatever `work` throws becomes the same AgreedError on all ranks, as with agree(), but here `work` may call
/// collectives. Only one thing cannot be mended: a rank whose error is its own (memory that is short between two
/// collectives) cannot call back ranks that wait for it. It waits `patience` seconds for them to fail as well, then
/// throws Error(kAlone), and the caller can only end the run. Duplicates are freed in all cases but this one.
///
/// Throws Error(kUsage) when MPI is not running, or the communicator is none of those that will do (not collective,
/// since there is nobody to agree with).
void run_as_guest(MpiHandle caller, const std::function<void(const Comm&)>& work, double patience = kPatience);

}  // namespace skein
