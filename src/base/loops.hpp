// Hints for loops that the compiler shall turn into vector code.
#pragma once

/// Before a loop whose turns do not depend on each other, which gcc cannot always see. clang looks for itself.
#if defined(__GNUC__) && !defined(__clang__)
#define SKEIN_INDEPENDENT_LOOP _Pragma("GCC ivdep")
#else
#define SKEIN_INDEPENDENT_LOOP
#endif
