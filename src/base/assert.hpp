// Assertions in three weights, chosen when Skein is built: SKEIN_ASSERT_LEVEL 0 none, 1 light (constant time, always
// affordable), 2 normal (time of the operation at hand), 3 heavy (time of the whole mesh, or at every access to an
// array).
#pragma once
#include <cstdio>
#include <cstdlib>
#include <string>

#ifndef SKEIN_ASSERT_LEVEL
#define SKEIN_ASSERT_LEVEL 1
#endif

namespace skein {

/// Ends the program with a line that tells what does not hold, and where.
[[noreturn]] inline void assertion_failed(const char* file, int line, const char* what) noexcept {
  std::fprintf(stderr, "%s:%d: assertion failed: %s\n", file, line, what);
  std::abort();
}

}  // namespace skein

// `fault` is a text that is empty when all is well, such as check(mesh). Not evaluated below its level.
#define SKEIN_ASSERT_NO_FAULT_AT(level, fault)                                                      \
  do {                                                                                              \
    if constexpr ((level) <= SKEIN_ASSERT_LEVEL) {                                                  \
      const std::string skein_fault = (fault);                                                      \
      if (!skein_fault.empty()) ::skein::assertion_failed(__FILE__, __LINE__, skein_fault.c_str()); \
    }                                                                                               \
  } while (false)
#define SKEIN_ASSERT_AT(level, condition)                                          \
  do {                                                                             \
    if constexpr ((level) <= SKEIN_ASSERT_LEVEL) {                                 \
      if (!(condition)) ::skein::assertion_failed(__FILE__, __LINE__, #condition); \
    }                                                                              \
  } while (false)
#define SKEIN_ASSERT_LIGHT(condition) SKEIN_ASSERT_AT(1, condition)
#define SKEIN_ASSERT_NORMAL(condition) SKEIN_ASSERT_AT(2, condition)
#define SKEIN_ASSERT_HEAVY(condition) SKEIN_ASSERT_AT(3, condition)
