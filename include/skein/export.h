/// \file
/// Marks what the shared library shows; everything else in it is hidden.
#pragma once
#if defined(__GNUC__) || defined(__clang__)
#define SKEIN_EXPORT __attribute__((visibility("default")))
#else
#define SKEIN_EXPORT
#endif
