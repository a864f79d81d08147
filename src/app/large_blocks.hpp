// Memory of the process: see large_blocks.cpp.
#pragma once

namespace skein::app {

/// From now on arrays of 1 MB and more come straight from the system, in large pages where it has them, and go back to
/// it when they are freed. To be called before there are threads. SKEIN_LARGE_PAGES=0 in the environment leaves all to
/// malloc.
void use_large_blocks() noexcept;

/// What is kept for the next array goes back to the system, which can use it for what is written to files.
void give_back_spare_blocks() noexcept;

}  // namespace skein::app
